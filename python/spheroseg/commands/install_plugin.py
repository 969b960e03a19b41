# SPDX-License-Identifier: GPL-3.0-or-later
"""Installs the plugin into the MeshLab application of this user.

Asks MeshLab for its release and precision, compares them with those that the plugin was built for,
and copies it to the folder in which MeshLab looks for added plugins. Start MeshLab again after it.
"""

from spheroseg import install


def add_arguments(parser):
    parser.add_argument(
        "--meshlab", metavar="PROGRAM", help="MeshLab's program or AppImage (meshlab on the PATH)"
    )
    parser.add_argument(
        "--directory", metavar="DIR", help="plugin folder (the user's own for that MeshLab)"
    )
    parser.add_argument("--plugin", metavar="FILE", help="plugin file (the package's own)")


def run(arguments) -> int:
    path = install.install_plugin(
        arguments.directory, meshlab=arguments.meshlab, plugin=arguments.plugin
    )
    print(f"installed {path} for {install.plugin_host(path)}")
    return 0
