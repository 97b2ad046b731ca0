# SPDX-License-Identifier: Apache-2.0
"""Laws of the blink code: ids come back through wrong frames, and what is no id is none."""

import numpy as np
import pytest

from robotskin.errors import InputError
from robotskin.selfconfig.localisation.blink_code import (
    DARK,
    MOST_WRONG,
    PERIOD_FRAMES,
    WHITE,
    WORD_FRAMES,
    colours,
    decode,
    words,
)


def test_any_two_ids_differ_in_seven_frames() -> None:
    every = np.arange(1, 16383)
    word = words(every)
    # The code is linear, so the least distance is the least number of ones; and the id can be read off the word.
    assert word.sum(axis=1).min() == 2 * MOST_WRONG + 1
    assert np.array_equal(word[:, :14] @ (1 << np.arange(13, -1, -1)), every)


def test_words_add_up_to_words(seed: int) -> None:
    random = np.random.default_rng(seed)
    a, b = random.integers(1, 16383, (2, 500))
    apart = a != b
    assert np.array_equal(words(a[apart]) ^ words(b[apart]), words((a ^ b)[apart]))


def test_three_wrong_frames_are_corrected_and_hidden_ones_survived(seed: int) -> None:
    random = np.random.default_rng(seed)
    ids = random.choice(np.arange(1, 16383), 300, replace=False)
    seen = np.where(words(ids), 1.0, -1.0)
    for row in seen:
        row[random.choice(WORD_FRAMES, MOST_WRONG, replace=False)] *= -1
    assert np.array_equal(decode(seen, ids), np.arange(len(ids)))
    hidden = np.where(words(ids), 1.0, -1.0)
    for row in hidden:
        row[random.choice(WORD_FRAMES, 5, replace=False)] = np.nan
    assert np.array_equal(decode(hidden, ids), np.arange(len(ids)))


def test_what_is_no_id_is_none(seed: int) -> None:
    random = np.random.default_rng(seed)
    ids = random.choice(np.arange(1, 16383), 300, replace=False)
    noise = random.choice([-1.0, 1.0], (3000, WORD_FRAMES))
    wrong = (decode(noise, ids) >= 0).mean()
    # Of 2^29 words, 300 times those within three frames of one are taken: 0.0023.
    assert wrong < 0.01
    assert np.all(decode(np.zeros((4, WORD_FRAMES)), ids) == -1)
    mirrored = np.where(words(ids[[5, 5, 9]]), 1.0, -1.0)
    assert decode(mirrored, ids).tolist() == [-1, -1, 9]


def test_a_period_has_one_dark_frame_at_its_beginning() -> None:
    table = colours([1, 77, 16382])
    assert table.shape == (PERIOD_FRAMES, 3)
    assert np.all(table[0] == DARK)
    assert np.all(table[1] == WHITE)
    assert np.all(table[2:] != DARK)


@pytest.mark.parametrize("value", [0, 16383, -4])
def test_an_id_that_no_cell_has_is_refused(value: int) -> None:
    with pytest.raises(InputError, match="1 to 16382"):
        words([5, value])
