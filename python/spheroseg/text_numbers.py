# SPDX-License-Identifier: GPL-3.0-or-later
"""Words and whole numbers in the bytes of a text, as numpy arrays."""

from __future__ import annotations

import re

import numpy as np

_MOST_DIGITS = 18  # fit into 64 bits
#: What a text must end with for `whole_numbers`.
PADDING = bytes(_MOST_DIGITS + 2)
BLANK, _PLUS, _MINUS, _ZERO, _POINT, _EXPONENT = b" +-0.e"
_LOWER_CASE = 0x20
_NO_FIGURE = np.ones(256, dtype=bool)
_NO_FIGURE[list(b" \t\n\v\f\r0123456789+-.eE\0")] = False
_NOT_FINITE = re.compile(rb"[+-]?(nan|inf|infinity)(?![!-~])", re.I)


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


def number_kinds(text: np.ndarray, begins: np.ndarray) -> tuple[np.ndarray, int | None]:
    """Of each word whether it is no fraction and has no exponent; and the first word that C's
    scanf would not take for one number."""

    def words_at(places: np.ndarray) -> np.ndarray:
        return np.searchsorted(begins, places, side="right") - 1

    is_whole = np.ones(len(begins), dtype=bool)
    letters = text | _LOWER_CASE
    marks = np.flatnonzero((text == _POINT) | (letters == _EXPONENT))
    owners = words_at(marks)
    is_whole[owners] = False
    is_in_order = (text[marks[:-1]] == _POINT) & (letters[marks[1:]] == _EXPONENT)
    odd = [owners[1:][(owners[1:] == owners[:-1]) & ~is_in_order]]
    signs = np.flatnonzero((text == _PLUS) | (text == _MINUS))
    owners = words_at(signs)
    odd.append(owners[(begins[owners] != signs) & (letters[signs - 1] != _EXPONENT)])
    others = np.unique(words_at(np.flatnonzero(_NO_FIGURE[text])))
    odd.append([word for word in others if not _NOT_FINITE.match(text[begins[word] :][:40])])
    found = np.concatenate(odd)
    return is_whole, int(found.min()) if len(found) else None
