# SPDX-License-Identifier: Apache-2.0
"""The paths of both arms as they were taught by hand: postures of sweeps, a file of them, and the paths they make."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from robotskin.apps.embrace.arms import SIDES, Arms, Paths
from robotskin.apps.embrace.regulation import NEAR_M, OPEN_M, TIGHT_M
from robotskin.errors import RobotskinError
from robotskin.whole_file import whole_file

Array = NDArray[np.float64]

FORMAT, VERSION = "robotskin-embrace-path", 1
ADVICE = "teach one with robotskin app embrace --teach FILE"
LEAST_POSTURES, LEAST_SWEEPS = 2, 2
LEAST_STEP_M = 0.02
"""Between the forearms of two postures, and between the axes of two sweeps: from nearer ones no way can be told."""
RADII_M = (TIGHT_M, 0.13, 0.16, 0.20, 0.25, 0.30, OPEN_M)


class TaughtPathError(RobotskinError):
    """A file of taught postures that cannot be read, or postures that make no path."""


class Sweep(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One way on which both arms close. postures: from open to closed, rad of the file's joints."""

    about: str
    postures: tuple[tuple[float, ...], ...]


class TaughtPath(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a person showed: sweeps, of the joints of both arms, left then right."""

    format: str
    version: int
    robot: str
    joints: tuple[str, ...]
    sweep: tuple[Sweep, ...]

    def save(self, file: Path) -> None:
        """Write it as TOML, whole or not at all. Raises TaughtPathError for a file that cannot be written."""
        lines = ["# Postures of both arms, led by hand: sweeps from open to closed, the first far before the chest."]
        lines += [f'format = "{FORMAT}"', f"version = {VERSION}", f'robot = "{self.robot}"']
        lines += [f"joints = {msgspec.json.encode(self.joints).decode()}"]
        for one in self.sweep:
            rows = [f"  [{', '.join(f'{angle:.4f}' for angle in posture)}]," for posture in one.postures]
            lines += ["", "[[sweep]]", f'about = "{one.about}"', "postures = [", *rows, "]"]
        try:
            with whole_file(file) as partial:
                partial.write_text("\n".join(lines) + "\n")
        except OSError as error:
            raise TaughtPathError(f"taught path {file}: cannot be written: {error.strerror}") from None

    def paths(self, arms: Arms) -> Paths:
        """The paths between and a little beyond the postures.

        A posture's axis lies midway between the middles of both forearms, and its radius is their distance from it.
        Raises TaughtPathError for postures of another robot, or that do not close or come nearer to the chest.
        """
        joints = tuple(arms.robot.joint_names[joint] for side in SIDES for joint in arms.joints[side])
        if self.joints != joints:
            raise TaughtPathError(
                f"taught path of {self.robot}: its joints are {', '.join(self.joints)}, the arms' {', '.join(joints)}"
            )
        if len(self.sweep) < LEAST_SWEEPS:
            raise TaughtPathError(f"taught path: {len(self.sweep)} sweep, at least {LEAST_SWEEPS} are needed; {ADVICE}")
        rows = sorted((self._row(arms, number) for number in range(len(self.sweep))), key=lambda row: row[0])
        axes = np.array([axis for axis, _ in rows])
        if np.diff(axes).min() < LEAST_STEP_M:
            told = ", ".join(f"{axis:.3f}" for axis in axes)
            raise TaughtPathError(
                f"taught path: its sweeps lie {told} m before the chest's joint, and must be {LEAST_STEP_M} m apart"
            )
        # One more row as near as a pull ends.
        axis_m = np.array([NEAR_M, *axes]) if axes[0] > NEAR_M + 1e-6 else axes
        angles = {
            side: np.array([_between(axes, np.array([row[side] for _, row in rows]), axis) for axis in axis_m])
            for side in SIDES
        }
        return Paths(axis_m, np.array(RADII_M), angles)

    def _row(self, arms: Arms, number: int) -> tuple[float, dict[str, Array]]:
        """Metres of a sweep's axis before the chest's joint, and of each side (S, 7) rad at `RADII_M`."""
        sweep = self.sweep[number]
        told = np.array([_whole(arms, posture, sweep.about) for posture in sweep.postures])
        middles = {side: np.array([forearm_middle(arms, side, posture) for posture in told]) for side in SIDES}
        axis = float(np.mean([middles[side][:, 0] for side in SIDES]))
        angles = {}
        for side in SIDES:
            radius = np.linalg.norm(middles[side][:, :2] - [axis, 0.0], axis=1)
            if len(radius) < LEAST_POSTURES or np.diff(radius).max() > -LEAST_STEP_M:
                told_m = ", ".join(f"{value:.3f}" for value in radius)
                raise TaughtPathError(
                    f"sweep {sweep.about!r}: the {side} forearm is {told_m} m from the axis; give {LEAST_POSTURES} or "
                    f"more postures, each closed by {LEAST_STEP_M} m more than the one before; {ADVICE}"
                )
            own = told[::-1][:, arms.joints[side]]
            angles[side] = np.array([_between(radius[::-1], own, value) for value in RADII_M])
        return axis, angles


def load_taught_path(file: Path) -> TaughtPath:
    """Read what `save` wrote. Raises TaughtPathError, naming the file and what is wrong."""
    try:
        found = msgspec.toml.decode(file.read_bytes(), type=TaughtPath)
    except OSError as error:
        raise TaughtPathError(f"taught path {file}: {error.strerror}; {ADVICE}") from None
    except (msgspec.DecodeError, ValueError) as error:
        raise TaughtPathError(f"taught path {file}: {error}; {ADVICE}") from None
    if (found.format, found.version) != (FORMAT, VERSION):
        raise TaughtPathError(
            f"taught path {file}: {found.format} {found.version}; this version reads {FORMAT} {VERSION}"
        )
    return found


def forearm_middle(arms: Arms, side: str, posture: Array) -> Array:
    """(3,) metres from the chest's joint, of the point midway between elbow and wrist in a posture (n) rad."""
    places = arms.robot.base_from_link(posture)
    links = [arms.robot.link_index(f"arm_{side}_{number}_link") for number in (4, 7)]
    return np.asarray(places[links][:, :3, 3].mean(axis=0) - arms.origin)


def _whole(arms: Arms, posture: tuple[float, ...], about: str) -> Array:
    """(n) rad: home, with both arms as they were taught."""
    joints = arms.both
    if len(posture) != len(joints) or not np.isfinite(posture).all():
        raise TaughtPathError(f"sweep {about!r}: a posture is {list(posture)}; give {len(joints)} finite angles, rad")
    robot, whole = arms.robot, arms.home.copy()
    whole[joints] = posture
    outside = (whole < robot.lower - 1e-3) | (whole > robot.upper + 1e-3)
    if outside.any():
        joint = int(np.argmax(outside))
        raise TaughtPathError(
            f"sweep {about!r}: joint {robot.joint_names[joint]} is at {whole[joint]:.3f} rad; its limits are "
            f"{robot.lower[joint]:.3f} and {robot.upper[joint]:.3f}"
        )
    return whole


def _between(at: Array, values: Array, wanted: float) -> Array:
    """Values (K, ...) at rising places (K), on straight lines, at a place between or beyond them."""
    low = int(np.clip(np.searchsorted(at, wanted) - 1, 0, len(at) - 2))
    share = (wanted - at[low]) / (at[low + 1] - at[low])
    return np.asarray(values[low] + share * (values[low + 1] - values[low]))
