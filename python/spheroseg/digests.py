# SPDX-License-Identifier: GPL-3.0-or-later
"""What tells contents of files apart."""

import hashlib
from pathlib import Path

from spheroseg import plugin_path
from spheroseg.file_checks import check_is_file


def sha256(path: Path) -> str:
    """Raises InputError where that is no file: a pipe or a device may be read without end."""
    check_is_file(path)
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def sha256_of(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def plugin_digest() -> str:
    """Tells builds of the plugin apart."""
    return sha256(plugin_path())[:12]
