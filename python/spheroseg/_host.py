# SPDX-License-Identifier: GPL-3.0-or-later
"""PyMeshLab, imported such that it encodes the names of files as Python does.

Its Qt asks the locale for the encoding once, when it is loaded. In the locale C that is ASCII,
while Python takes UTF-8: Qt would look for files with question marks in their names.
"""

import contextlib
import locale
import sys
from collections.abc import Iterator


@contextlib.contextmanager
def _locale_of_python() -> Iterator[None]:
    before = locale.setlocale(locale.LC_CTYPE)
    in_utf8 = locale.nl_langinfo(locale.CODESET) == "UTF-8"
    if sys.getfilesystemencoding() == "utf-8" and not in_utf8:
        with contextlib.suppress(locale.Error):  # of a system without that locale
            locale.setlocale(locale.LC_CTYPE, "C.UTF-8")
    try:
        yield
    finally:
        locale.setlocale(locale.LC_CTYPE, before)


with _locale_of_python():
    import pymeshlab

__all__ = ["pymeshlab"]
