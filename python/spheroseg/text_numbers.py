# SPDX-License-Identifier: GPL-3.0-or-later
"""Words and whole numbers in the bytes of a text, as numpy arrays."""

from __future__ import annotations

import numpy as np

_MOST_DIGITS = 18  # fit into 64 bits
#: What a text must end with for `whole_numbers`.
PADDING = bytes(_MOST_DIGITS + 2)
BLANK, _PLUS, _MINUS, _ZERO = b" +-0"


def word_begins(text: np.ndarray) -> np.ndarray:
    """For each byte whether a word begins there."""
    ink = text > BLANK
    begins = ink.copy()
    begins[1:] = ink[1:] > ink[:-1]
    return begins


def whole_numbers(text: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The number at each place, 0 where there is none, as C's atoi reads it."""
    negative = text[places] == _MINUS
    places = places + (negative | (text[places] == _PLUS))
    numbers = np.zeros(len(places), dtype=np.int64)
    reading = np.ones(len(places), dtype=bool)
    for place in range(_MOST_DIGITS):
        digits = text[places + place] - np.uint8(_ZERO)
        reading &= digits < 10
        if not reading.any():
            break
        numbers = np.where(reading, 10 * numbers + digits, numbers)
    return np.where(negative, -numbers, numbers)
