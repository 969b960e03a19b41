# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark program, `python -m spheroseg.bench`: our efforts against graph partitioners."""
