# SPDX-License-Identifier: GPL-3.0-or-later
"""The subcommands of `spheroseg`, one module each; `spheroseg.cli` says how they are found."""
