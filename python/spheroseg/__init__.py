# SPDX-License-Identifier: GPL-3.0-or-later
"""Balanced, connected, bowtie-free segmentation of triangle meshes.

Importing the package loads the SpheroSeg plugin into PyMeshLab and binds its filters as methods of
`pymeshlab.MeshSet`; `segment`, `parametrize` and `measure` do the same work on plain arrays.
"""

import os
import sys

from spheroseg._command_line import ended_by_interrupt, is_command_line

with ended_by_interrupt():
    # Read once, when PyMeshLab loads OpenMP's library. Threads that spin for long while they wait
    # cost a busy machine several times the work itself; those that sleep at once are waked too
    # often (docs/performance.md, "Busy machines"). Where the library has been loaded already the
    # plugin has to find that nothing is set: then it sees to its threads by itself.
    if (
        "pymeshlab" not in sys.modules
        and os.environ.setdefault("OMP_WAIT_POLICY", "passive").lower() == "passive"
    ):
        os.environ.setdefault("GOMP_SPINCOUNT", "2000")

    from spheroseg._plugin import load_plugin, plugin_path
    from spheroseg.api import (
        Parametrization,
        Segmentation,
        measure,
        parametrize,
        segment,
    )
    from spheroseg.errors import InputError, PluginError
    from spheroseg.install import install_plugin

    try:
        load_plugin()
    except PluginError:
        # The command line can show its help without a plugin; what needs it says so itself.
        if not is_command_line():
            raise

__version__ = "0.1.0"

__all__ = [
    "InputError",
    "Parametrization",
    "PluginError",
    "Segmentation",
    "install_plugin",
    "load_plugin",
    "measure",
    "parametrize",
    "plugin_path",
    "segment",
]
