# SPDX-License-Identifier: GPL-3.0-or-later
"""Packages that only a part of this one needs."""

import importlib
from collections.abc import Mapping
from types import ModuleType

from spheroseg.errors import MissingPackageError

# The extra of pyproject.toml that brings each.
EXTRAS = {
    "pygltflib": "export",
    "distributed": "batch",
    "pyarrow": "batch",
    "jinja2": "evaluate",
    "kaminpar": "evaluate",
    "matplotlib": "evaluate",
    "mtkahypar": "evaluate",
    "numba": "evaluate",
    "pymetis": "evaluate",
    "pyvista": "evaluate",
}


def require(package: str, purpose: str) -> ModuleType:
    """Imports a package for `purpose`; a MissingPackageError says how to install it."""
    require_all({package: purpose})
    return importlib.import_module(package)


def require_all(purposes: Mapping[str, str]) -> None:
    """Imports each package for its purpose; a MissingPackageError names all that are missing, and
    says how to install them."""
    missing = {}
    for package, purpose in purposes.items():
        try:
            importlib.import_module(package)
        except ImportError as error:
            missing[package] = f"{purpose} needs the package '{package}' ({error})"
    if missing:
        extras = ",".join(sorted({EXTRAS[package] for package in missing}))
        raise MissingPackageError(
            f"{'; '.join(missing.values())}; install {'it' if len(missing) == 1 else 'them'} with "
            f"'pip install {' '.join(missing)}', or with all that such commands need: "
            f"pip install 'spheroseg[{extras}]' (in a checkout: make setup)"
        )
