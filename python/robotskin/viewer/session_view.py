# SPDX-License-Identifier: Apache-2.0
"""What the page sees of a running session, and what it may ask of it.

The page knows no world, driver or controller: a simulated arm, a replayed log and a real robot look the same to it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, Protocol, runtime_checkable

import numpy as np
import trimesh
from numpy.typing import NDArray

from robotskin.firmware import SENSORS
from robotskin.layout import Layout
from robotskin.skin import Health, SkinState

if TYPE_CHECKING:
    from robotskin.viewer.network_view import NetworkView

__all__ = [
    "Ball",
    "Goal",
    "Recordable",
    "RobotView",
    "SessionView",
    "SkinReading",
    "Snapshot",
    "Solid",
    "StoppedByHand",
    "Torques",
    "Touch",
]

Floats = NDArray[np.floating]
Integers = NDArray[np.integer]


class RobotView(Protocol):
    """What is drawn of a `robotskin.robots.Robot`: n joints, L links."""

    @property
    def joint_names(self) -> Sequence[str]:
        """The n joints, in the order of every joint array."""

    @property
    def joint_slides(self) -> Sequence[bool]:
        """Of each joint whether it slides, in metres; the others turn, in radians."""

    @property
    def lower(self) -> Floats:
        """(n,) rad or m; -inf where a joint has no end."""

    @property
    def upper(self) -> Floats:
        """(n,) rad or m; inf where a joint has no end."""

    @property
    def link_names(self) -> Sequence[str]:
        """The L links, in the order of `base_from_link`."""

    def links_with(self, surface: Literal["visual"]) -> Sequence[str]:
        """The links that have something to show."""

    def link_mesh(self, link: str, surface: Literal["visual"]) -> trimesh.Trimesh:
        """The surface of a link in its own frame, in metres."""

    def base_from_link(self, q: Floats) -> Floats:
        """(L, 4, 4) the pose of every link for the joint positions (n,) in rad or m."""


@dataclass(frozen=True)
class SkinReading:
    """What N cells felt last; a cell's values are its last ones, whatever its health."""

    normal_force: Floats
    """(N, 3) newton."""
    proximity: Floats
    """(N,) share of full scale."""
    distance: Floats
    """(N,) metres, +inf where nothing is near."""
    acceleration: Floats
    """(N, 3) m/s^2, specific force in the cell frame."""
    temperature: Floats
    """(N, 2) degrees Celsius."""
    health: Integers
    """(N,) the numbers of `robotskin.skin.Health`."""
    age_s: Floats
    """(N,) seconds since the cell's last sample, +inf for one that never sent any."""
    further: Mapping[str, tuple[Floats, str]] = field(default_factory=dict)
    """By column, (N,) or (N, channels) what sensors say that only some boards have, and its unit; NaN: unknown."""
    ill: Mapping[int, str] = field(default_factory=dict)
    """By cell, what its doctor says is wrong with it."""
    sensors: tuple[str, ...] = tuple(name for name, _, _, _, _ in SENSORS)
    """Names of those that the skin has; values of the others are NaN."""

    @classmethod
    def of(cls, skin: SkinState, now_ns: int, ill: Mapping[int, str] | None = None) -> "SkinReading":
        """A copy of a skin's state at a time of its own clock, with what a doctor says of its cells."""
        stamp_ns = np.array(skin.stamp_ns)
        return cls(
            normal_force=np.array(skin.normal_force),
            proximity=np.array(skin.proximity),
            distance=np.array(skin.distance),
            acceleration=np.array(skin.acceleration),
            temperature=np.array(skin.temperature),
            health=np.array(skin.health),
            age_s=np.where(stamp_ns > 0, (now_ns - stamp_ns) * 1e-9, np.inf),
            further={
                column: (np.array(getattr(skin, column)), unit) for _, column, _, unit, further in SENSORS if further
            },
            ill=ill or {},
            sensors=tuple(skin.sensors),
        )

    def cell_forces_n(self) -> Floats:
        """(N,) newton that each cell feels; one that is not alive, or is ill, feels nothing."""
        return np.where(self._counts(), np.asarray(self.normal_force, dtype=float).sum(axis=1), 0.0)

    def cell_nearness(self) -> Floats:
        """(N,) share of full scale; a cell that is not alive, or is ill, sees nothing."""
        return np.where(self._counts(), np.asarray(self.proximity, dtype=float), 0.0)

    def _counts(self) -> NDArray[np.bool_]:
        counts = np.asarray(self.health == int(Health.alive))
        counts[list(self.ill)] = False
        return counts


@dataclass(frozen=True)
class Touch:
    """What the session's hand is doing to which cell."""

    cell: int
    force_n: float = 0.0
    """The hand pushes against the cell's normal; 0 while it only approaches."""
    distance_m: float = 0.0
    """From the cell's face to the hand; 0 while it pushes."""


@dataclass(frozen=True)
class Ball:
    """A hand or an object near the robot, as big as it is."""

    position_m: Floats
    """(3,) in the base frame."""
    radius_m: float


@dataclass(frozen=True, eq=False)
class Solid:
    """A rigid piece of a thing around the robot; pieces of one thing have one name."""

    name: str
    mesh: trimesh.Trimesh
    """In its own frame, in metres; without faces where there is nothing to draw."""
    colour: tuple[int, int, int]


@dataclass(frozen=True)
class Torques:
    """What touch asks of the n joints, computed in two places."""

    host: Floats
    """(n,) Nm or N."""
    skin: Floats
    """(n,) Nm or N, by the cells; zero unless fresh."""
    fresh: bool
    """The skin's own are new."""
    cells: int
    """Summed by the skin."""


@dataclass(frozen=True)
class Goal:
    """What the behaviour is to reach."""

    kind: Literal["joints", "hand"]
    at: Floats
    """(n,) rad or m of the joints, or (3,) metres of the hand in the base frame."""
    given: bool = False
    """By a person; otherwise it is where the behaviour holds the robot by itself."""
    left: float = 0.0
    """Rad or m from it, of the worst joint or of the hand."""
    told: str = ""
    """Why it is not reached; empty where it is."""


@dataclass(frozen=True)
class Snapshot:
    """One moment of a session: nothing in it changes after it was taken."""

    time_s: float
    joint_position: Floats
    """(n,) rad or m."""
    skin: SkinReading
    interface: str
    mode: str
    skin_on: bool
    controller_state: str
    """What the controller does, in one or two words."""
    behaviour: str = ""
    """What it does, by name."""
    stop_reason: str = ""
    """Why it stopped; empty while it runs."""
    source: str = "host"
    """What computes the torque of the skin task: one of `robotskin.choices.SOURCES`."""
    source_refused: str = ""
    """Why only the host can at present; empty where there is a choice."""
    goal: Goal | None = None
    """None where the behaviour takes none."""
    held_back: str = ""
    """Which limits of which joints changed commands so far, and in how many ticks; empty where none did."""
    torques: Torques | None = None
    """What both sources say; None where the cells compute no torques."""
    touch: Touch | None = None
    hands: Sequence[Ball] = ()
    """Those that are at work."""
    marked: int | None = None
    """The cell that a person is asked to touch."""
    solids: Floats | None = None
    """(K, 4, 4) where the session's `solids` are, in the base frame; None where there are none."""
    statistics: Mapping[str, float] = field(default_factory=dict)
    """`realtime_factor`, `frames_per_s`, `datagrams_per_s`, `driver_cpu_percent`, `frames_lost`, `fallback_ticks`,
    `widened_ticks`, `intervention_share`; what is not known is left out."""
    parent: Integers | None = None
    """(N,) the cell to which a cell sends its frames, -1 for the section unit; None while the tree is not known."""


class SessionView(Protocol):
    """A session that a page shows. Every call may come from any thread, returns at once and never waits for a cycle.

    A command that cannot be obeyed raises `RobotskinError`; the page shows its message.
    """

    @property
    def robot(self) -> RobotView:
        """What is moved."""

    @property
    def layout(self) -> Layout:
        """What feels."""

    @property
    def solids(self) -> Sequence[Solid]:
        """What else there is: the K pieces of the things around the robot."""

    @property
    def title(self) -> str:
        """What the page is called."""

    @property
    def network(self) -> "NetworkView | None":
        """The cells' network, where it can be seen and meddled with."""

    def snapshot(self) -> Snapshot:
        """The latest moment."""

    def push(self, cell: int, force_n: float, duration_s: float | None = None) -> None:
        """Push a cell against its normal, for `duration_s` seconds or until `release`; changes a push that lasts."""

    def approach(self, cell: int, distance_m: float) -> None:
        """Hold a hand at that distance in front of a cell until `release`."""

    def release(self) -> None:
        """Take the hand away."""

    def set_interface(self, interface: str) -> None:
        """Command the robot through one of `robotskin.choices.INTERFACES`."""

    @property
    def behaviours(self) -> Mapping[str, str]:
        """What the robot can be told to do, by name, and what each means; empty where that is fixed."""

    def set_behaviour(self, behaviour: str) -> None:
        """Do one of `behaviours`."""

    def set_goal(self, goal: Floats) -> None:
        """Go there: (n,) rad or m of the joints, or (3,) metres of the hand in the base frame, as `Goal.kind` says."""

    def set_mode(self, mode: str) -> None:
        """Let the cells send in one of `robotskin.choices.MODES`."""

    def set_source(self, source: str) -> None:
        """Let one of `robotskin.choices.SOURCES` compute the torque of the skin task."""

    def set_skin(self, on: bool) -> None:
        """Let the skin move the robot, or not."""

    def reset(self) -> None:
        """Back to the start: posture, controller, hand."""


@runtime_checkable
class Recordable(Protocol):
    """A session that can be recorded from the page."""

    @property
    def recording(self) -> str:
        """What is recorded, or was last, and where; empty: nothing yet."""

    def record(self, on: bool) -> None:
        """Record into a new file from now on, or end it."""


@runtime_checkable
class StoppedByHand(Protocol):
    """A session that moves a real robot: the page has a key that stops it, and one that lets it use its speed."""

    def stop(self) -> None:
        """Stop smoothly, and hold until `SessionView.reset`."""

    def confirm(self) -> None:
        """Robot and skin do what they should: full speed."""
