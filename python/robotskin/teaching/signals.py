# SPDX-License-Identifier: Apache-2.0
"""A demonstration seen by skin and joints alone, 50 times a second: motion, thing in hand, squeeze, goal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.teaching.touching import HOLD_N
from robotskin.teaching.worker import Worker

Array = NDArray[np.float64]

PERIOD_S = 0.02
CUT_OFF_HZ = 5.0
MOVES_M_S, RESTS_M_S = 0.005, 0.003
STANDS_S = 0.20
"""A hand that stops for less is still on its way."""
HOLDS_N, EMPTY_N = 0.3, 0.2
LOOSER_N, TIGHTER_N, SQUEEZE_ENDS_S = 0.75, 0.9, 0.25
"""From the force of a hold; a squeeze that loosens first passes through that force on its way."""
CLOSES_M_S, OPENS_M_S = 0.006, 0.015
NEAR_PLACE_M, NEARING, LEFT_M = 0.05, 0.4, 0.09
"""A hand that rests so near to a place is at it; one that moves goes there if so much of its speed brings it nearer.
A hand has emptied itself until it is so far from where it let go."""

FEATURES = ("motion", "hand", "pads", "squeezing", "towards")


@dataclass(frozen=True)
class Frame:
    """One moment. Every feature is a word."""

    time_s: float
    motion: str
    """still, moves"""
    hand: str
    """empty, holds, emptied: it has just let go"""
    pads: str
    """still, closing, opening"""
    squeezing: str
    """no, yes"""
    towards: str
    """nothing, something: whether a place is being neared or near"""
    near: str
    """Name of the place that the hand is at; empty for none."""

    @property
    def situation(self) -> tuple[str, ...]:
        """The features in order."""
        return (self.motion, self.hand, self.pads, self.squeezing, self.towards)


class _Lasting:
    """A word that changes once the new one has lasted for its time."""

    def __init__(self, word: str, lasts_s: Mapping[str, float]) -> None:
        self.word, self._next, self._since, self._lasts_s = word, word, 0.0, lasts_s

    def look(self, word: str) -> str:
        if word == self.word:
            self._next, self._since = word, 0.0
        else:
            self._since = self._since + PERIOD_S if word == self._next else PERIOD_S
            self._next = word
            if self._since >= self._lasts_s[word] - 1e-9:
                self.word, self._since = word, 0.0
        return self.word


class Watcher:
    """Makes frames of what a worker's joints and pads say. places: (3) metres each, by name."""

    def __init__(self, places: Mapping[str, Array]) -> None:
        self.places = dict(places)
        self._place: Array | None = None
        self._velocity, self._pad_speed, self._opening = np.zeros(3), 0.0, 0.0
        self._motion = _Lasting("still", {"still": STANDS_S, "moves": 0.04})
        self._hand = _Lasting("empty", {"empty": 0.06, "holds": 0.06})
        self._pads = _Lasting("still", {"still": 0.06, "closing": 0.06, "opening": 0.06})
        self._squeezing = _Lasting("no", {"yes": 0.06, "no": SQUEEZE_ENDS_S})
        self._towards = _Lasting("nothing", {"nothing": 0.2, "something": 0.1})
        self._settled = False
        self._let_go: Array | None = None

    def look(self, worker: Worker) -> Frame:
        """The frame of this moment, 20 ms after the one before."""
        return self.of(worker.now_s, worker.place_m, float(worker.openings_m.sum()), worker.force_n)

    def of(self, time_s: float, place_m: Array, opening_m: float, force_n: Array) -> Frame:
        """The frame of a place of the hand (3), the pads' opening and their forces (2)."""
        before = place_m if self._place is None else self._place
        if self._place is None:
            self._opening = opening_m
        gain = 1.0 - np.exp(-2 * np.pi * CUT_OFF_HZ * PERIOD_S)
        self._velocity += gain * ((place_m - before) / PERIOD_S - self._velocity)
        self._pad_speed += gain * ((opening_m - self._opening) / PERIOD_S - self._pad_speed)
        self._place, self._opening = place_m, opening_m
        speed = float(np.linalg.norm(self._velocity))
        least = RESTS_M_S if self._motion.word == "moves" else MOVES_M_S
        motion = self._motion.look("moves" if speed > least else "still")
        pads = "closing" if self._pad_speed < -CLOSES_M_S else "opening" if self._pad_speed > OPENS_M_S else "still"
        near = self._near(place_m)
        towards = "something" if self._goes_somewhere(place_m, speed, near) else "nothing"
        hand = self._held(place_m, force_n)
        squeezing = self._squeezed(hand == "holds" and motion == "still", float(force_n.mean()))
        return Frame(time_s, motion, hand, self._pads.look(pads), squeezing, self._towards.look(towards), near)

    def _held(self, place_m: Array, force_n: Array) -> str:
        held = self._hand.word == "holds"
        hand = self._hand.look("holds" if (force_n > (EMPTY_N if held else HOLDS_N)).all() else "empty")
        if hand == "holds":
            self._let_go = None
        elif held:
            self._let_go = place_m
        elif self._let_go is not None and float(np.linalg.norm(place_m - self._let_go)) > LEFT_M:
            self._let_go = None
        return hand if self._let_go is None else "emptied"

    def _squeezed(self, could: bool, force_n: float) -> str:
        beyond = force_n < HOLD_N - LOOSER_N or force_n > HOLD_N + TIGHTER_N
        # A hold that has just begun is no squeeze: its force has yet to rise.
        self._settled = self._hand.word == "holds" and (self._settled or not beyond)
        return self._squeezing.look("yes" if could and self._settled and beyond else "no")

    def _near(self, place_m: Array) -> str:
        distance = {name: float(np.linalg.norm(place - place_m)) for name, place in self.places.items()}
        best = min(distance, key=distance.__getitem__, default="")
        return best if best and distance[best] < NEAR_PLACE_M else ""

    def _goes_somewhere(self, place_m: Array, speed: float, near: str) -> bool:
        """Whether the hand goes to a place, or is at one."""
        if speed < MOVES_M_S:
            return bool(near)
        ways = [place - place_m for place in self.places.values()]
        return any(self._velocity @ way > NEARING * speed * max(float(np.linalg.norm(way)), 1e-9) for way in ways)
