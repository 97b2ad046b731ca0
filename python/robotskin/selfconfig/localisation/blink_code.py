# SPDX-License-Identifier: Apache-2.0
"""Cells blink their ids: an id of 14 bits as colours over 31 frames, found again wherever a camera began to look.

In: ids of cells. Out: the colour of each cell in each frame, for the firmware's `led` command; and back, from what
a camera saw. What can go wrong: a blob that is no cell, or hidden for too long: no id, never a wrong one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin import firmware
from robotskin.errors import InputError

Array = NDArray[np.float64]

DATA_BITS = 14
WORD_FRAMES = 29
"""The BCH code (31, 16) of distance 7, shortened by two bits: up to three wrong frames are corrected."""
PERIOD_FRAMES = WORD_FRAMES + 2
"""All dark, then all white, then the word. Only the first frame is dark, so that it marks the beginning."""
GENERATOR = 0b1000111110101111
"""x^15 + x^11 + x^10 + x^9 + x^8 + x^7 + x^5 + x^3 + x^2 + x + 1, product of three minimal polynomials."""
MOST_WRONG = 3

DARK, WHITE, RED, BLUE = 0x000000, 0xFFFFFF, 0xFF0000, 0x0000FF


def words(ids: ArrayLike) -> NDArray[np.bool_]:
    """(N, 29) code words of ids (N,): the id, highest bit first, then 15 check bits.

    Raises:
        InputError: an id that no cell can have.
    """
    ids = np.asarray(ids, dtype=np.int64).reshape(-1)
    wrong = (ids < firmware.ID_FIRST) | (ids > firmware.ID_LAST)
    if wrong.any():
        raise InputError(f"id {ids[wrong][0]}: must be {firmware.ID_FIRST} to {firmware.ID_LAST}")
    word = ids << 15
    rest = word.copy()
    for bit in range(WORD_FRAMES - 1, 14, -1):
        rest = np.where(rest >> bit & 1, rest ^ (GENERATOR << (bit - 15)), rest)
    word |= rest
    return (word[:, None] >> np.arange(WORD_FRAMES - 1, -1, -1) & 1).astype(bool)


def colours(ids: ArrayLike) -> NDArray[np.uint32]:
    """(31, N) 0xRRGGBB of each cell in each frame of a period: dark, white, then red for 1 and blue for 0."""
    word = words(ids)
    table = np.empty((PERIOD_FRAMES, len(word)), dtype=np.uint32)
    table[0], table[1] = DARK, WHITE
    table[2:] = np.where(word.T, RED, BLUE)
    return table


def decode(seen: Array, ids: ArrayLike) -> NDArray[np.int64]:
    """Which cell each blob is.

    Args:
        seen: (B, 29) redness of B blobs in the frames of the word: 1 red, -1 blue, 0 or NaN not told.
        ids: (N,) of the cells that exist.

    Returns:
        (B,) index into `ids`, or -1: more than three frames are wrong, fewer than 20 are told, another id fits
        hardly worse, or two blobs claim the same cell (a mirror image is not the cell).
    """
    seen = np.nan_to_num(np.asarray(seen, dtype=float).reshape(-1, WORD_FRAMES))
    signs = np.where(words(ids), 1.0, -1.0)
    result = np.full(len(seen), -1, dtype=np.int64)
    if len(signs) == 0 or len(seen) == 0:
        return result
    agreement = np.clip(seen, -1, 1) @ signs.T
    order = np.argsort(agreement, axis=1)
    best = order[:, -1]
    told = np.abs(seen) > 0.25
    wrong = (told & (np.sign(seen) != signs[best])).sum(axis=1)
    clear = np.ones(len(seen), dtype=bool)
    if len(signs) > 1:
        rows = np.arange(len(seen))
        clear = agreement[rows, best] - agreement[rows, order[:, -2]] > 1.0
    good = (wrong <= MOST_WRONG) & (told.sum(axis=1) >= 20) & clear & (agreement.max(axis=1) > 0)
    result[good] = best[good]
    claimed, times = np.unique(result[good], return_counts=True)
    result[np.isin(result, claimed[times > 1])] = -1
    return result
