# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m spheroseg` is the command line."""

import sys

from spheroseg.cli import main

sys.exit(main())
