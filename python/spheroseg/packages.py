# SPDX-License-Identifier: GPL-3.0-or-later
"""Packages that only a part of this one needs."""

import importlib
from types import ModuleType

from spheroseg.errors import MissingPackageError


def require(package: str, purpose: str) -> ModuleType:
    """Imports a package for `purpose`; a MissingPackageError says how to install it."""
    try:
        return importlib.import_module(package)
    except ImportError as error:
        raise MissingPackageError(
            f"{purpose} needs the package '{package}' ({error}); install it with "
            f"'pip install {package}' (in a checkout: make setup)"
        ) from error
