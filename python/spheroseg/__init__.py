# SPDX-License-Identifier: GPL-3.0-or-later
"""Balanced, connected, bowtie-free segmentation of triangle meshes.

Importing the package loads the SpheroSeg plugin into PyMeshLab and binds its filters as methods of
`pymeshlab.MeshSet`; `segment`, `parametrize` and `measure` do the same work on plain arrays.
"""

import os
import sys

from spheroseg._command_line import ended_by_interrupt, is_command_line


def _let_threads_sleep():
    """Has OpenMP's threads spin for some tens of microseconds only while they wait, unless the
    environment says otherwise. Those that spin for long cost a busy machine several times the work
    itself; those that sleep at once are waked too often (docs/performance.md, "Busy machines")."""
    if os.environ.setdefault("OMP_WAIT_POLICY", "passive").lower() == "passive":
        os.environ.setdefault("GOMP_SPINCOUNT", "2000")


with ended_by_interrupt():
    # OpenMP's library reads the environment once, when PyMeshLab loads it. Where it is loaded
    # already, the plugin has to find that nothing was set: then it sees to its threads by itself.
    # Set afterwards, the environment is for processes that are started later.
    _openmp_is_loaded = "pymeshlab" in sys.modules
    if not _openmp_is_loaded:
        _let_threads_sleep()

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

    if _openmp_is_loaded:
        _let_threads_sleep()

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
