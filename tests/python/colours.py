# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of glTF files as those of PLY files."""

import numpy as np


def bytes_of_linear(linear) -> np.ndarray:
    """Linear shares of light as sRGB (IEC 61966-2-1), 0 to 255."""
    linear = np.asarray(linear, float)
    share = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.round(255 * share).astype(int)
