# SPDX-License-Identifier: GPL-3.0-or-later
"""What holds for all tests."""

import os

# Before any test imports PyMeshLab, which most do before the package: docs/performance.md, "Busy
# machines".
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
