# SPDX-License-Identifier: GPL-3.0-or-later
"""Words and whole numbers in the bytes of a text, as numpy arrays."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from spheroseg.errors import InputError

_MOST_DIGITS = 18  # fit into 64 bits
#: What a text must end with for `whole_numbers`.
PADDING = bytes(_MOST_DIGITS + 2)
#: What may follow the end of what a header declares.
FILLING = b"\0\x1a \t\r\n"
BLANK, _PLUS, _MINUS, _ZERO, _POINT, _EXPONENT = b" +-0.e"
_LOWER_CASE = 0x20
_OF_FIGURES = b" \t\n\v\f\r0123456789+-.eE\0"
#: Words without digits that are numbers to C's scanf, and to its atof.
_OF_SCANF = re.compile(rb"[+-]?(nan|inf|infinity)(?![!-~])", re.I)
OF_ATOF = re.compile(rb"[+-]?(nan(\(\w*\))?|inf|infinity)(?![!-~])", re.I)
_MOST_SHOWN = 40


def legible(text: bytes) -> str:
    """What a file says, as messages show it."""
    return text.decode(errors="replace")[:_MOST_SHOWN]


def word_at(text: np.ndarray, place: int) -> str:
    """The word that begins there, as messages show it."""
    return legible(text[place : place + _MOST_SHOWN].tobytes().split()[0])


def no_number(path: Path, line: int, word: str) -> InputError:
    """The error about a word that is none."""
    return InputError(f"{path}: line {line}: '{word}' is no number; the file is damaged")


def others_than(characters: bytes, text: np.ndarray) -> np.ndarray:
    """The places at which the text has a character that is not one of `characters`."""
    if not text.tobytes().translate(None, characters):  # faster than what follows
        return np.zeros(0, dtype=np.int64)
    is_other = np.ones(256, dtype=bool)
    is_other[list(characters)] = False
    return np.flatnonzero(is_other[text])


def word_begins(text: np.ndarray) -> np.ndarray:
    """For each byte whether a word begins there."""
    ink = text > BLANK
    begins = ink.copy()
    begins[1:] = ink[1:] > ink[:-1]
    return begins


def whole_numbers(text: np.ndarray, places: np.ndarray) -> np.ndarray:
    """int64: the number at each place as C's atoi reads it, 0 where there is none. At most
    _MOST_DIGITS digits count, from the first one that is not 0 on. The text must end with PADDING.
    """
    negative = text[places] == _MINUS
    places = places + (negative | (text[places] == _PLUS))
    zeros = (text[places] == _ZERO) & (text[places + 1] == _ZERO)
    if zeros.any():
        others = np.flatnonzero(text != _ZERO)
        places[zeros] = others[np.searchsorted(others, places[zeros])]
    numbers = np.zeros(places.shape, dtype=np.int64)
    reading = np.ones(places.shape, dtype=bool)
    for place in range(_MOST_DIGITS):
        digits = text[places + place] - np.uint8(_ZERO)
        reading &= digits < 10
        if not reading.any():
            break
        numbers = np.where(reading, 10 * numbers + digits, numbers)
    return np.where(negative, -numbers, numbers)


def number_kinds(
    text: np.ndarray, begins: np.ndarray, without_figures: re.Pattern = _OF_SCANF
) -> tuple[np.ndarray, int | None]:
    """For each word whether it has neither a fraction nor an exponent, and the index of the first
    word that C does not read as one number, or None.

    text: uint8, ends with PADDING. begins: where the words begin, rising.
    """

    def words_at(places: np.ndarray) -> np.ndarray:
        return np.searchsorted(begins, places, side="right") - 1

    def have_figures(places: np.ndarray) -> np.ndarray:
        return text[places] - np.uint8(_ZERO) < 10

    def behind_signs(places: np.ndarray) -> np.ndarray:
        return places + ((text[places] == _PLUS) | (text[places] == _MINUS))

    is_whole = np.ones(len(begins), dtype=bool)
    letters = text | _LOWER_CASE
    marks = np.flatnonzero((text == _POINT) | (letters == _EXPONENT))
    owners = words_at(marks)
    is_whole[owners] = False
    is_in_order = (text[marks[:-1]] == _POINT) & (letters[marks[1:]] == _EXPONENT)
    odd = [owners[1:][(owners[1:] == owners[:-1]) & ~is_in_order]]
    exponents = marks[letters[marks] == _EXPONENT]
    odd.append(words_at(exponents[~have_figures(behind_signs(exponents + 1))]))
    signs = np.flatnonzero((text == _PLUS) | (text == _MINUS))
    owners = words_at(signs)
    odd.append(owners[(begins[owners] != signs) & (letters[signs - 1] != _EXPONENT)])
    odd.append(words_at(others_than(_OF_FIGURES, text)))
    first = behind_signs(begins)
    odd.append(np.flatnonzero(~have_figures(first + (text[first] == _POINT))))
    for word in np.unique(np.concatenate(odd)):
        if not without_figures.match(text[begins[word] :][:_MOST_SHOWN]):
            return is_whole, int(word)
    return is_whole, None
