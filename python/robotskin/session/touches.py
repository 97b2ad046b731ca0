# SPDX-License-Identifier: Apache-2.0
"""What a person would do to a skinned robot, as steps of a session: push, hold, release, press; and what came of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from robotskin.errors import UnknownNameError
from robotskin.firmware import PORT_POINTS_M
from robotskin.layout import Layout
from robotskin.model import RobotDynamics, RobotModel
from robotskin.robots import Robot
from robotskin.robots.gains import GainSet
from robotskin.robots.standing import feet_of
from robotskin.session import PERIOD_S, Session, SessionError
from robotskin.skin import STANDARD_GRAVITY_MPS2, SkinModel

HAND_WAY_M, HAND_WIDTH_M = 0.14, 0.035
"""What a hand needs in front of a cell: its way, and its radius with a little room."""
SURFACE_POINT_M2 = 2e-4
SEAM_REACH_M = 0.03
FLAT = float(np.cos(np.radians(10)))

Watch = Callable[[float], None]
"""Called after each period of a touch with the seconds that have passed in it."""


@dataclass(frozen=True)
class Push:
    """What a push of a cell did. displacement_m: of the cell at the end of the hold; expected_m: what the gains say for
    what the skin felt before the push and then; peak_m: at most;
    return_error_rad: of the worst joint, some time after the release."""

    displacement_m: float
    expected_m: float
    peak_m: float
    return_error_rad: float


@dataclass(frozen=True)
class Press:
    """A press measured twice, in newton and averaged over the same time: by the skin, and MuJoCo's contact force."""

    felt_n: float
    contact_n: float

    @property
    def relative_error(self) -> float:
        """Of the felt force."""
        return abs(self.felt_n - self.contact_n) / self.contact_n


def push_and_release(
    session: Session,
    cell: int,
    force_n: float,
    hold_s: float = 2.0,
    rest_s: float = 2.0,
    at_m: tuple[float, float] = (0.0, 0.0),
) -> Push:
    """Push a cell with a force, hold it, let go, and wait.

    The hold begins when the hand has nine tenths of its force. Raises SessionError if it never gets there.
    """
    start = session.cell_position(cell)
    joints, before = np.array(session.joints.position), turn_by_touch(session)
    session.world.push(session.in_world(cell), force_n, at_m)
    _come_to_force(session, force_n)
    peak = 0.0
    for _ in range(round(hold_s / PERIOD_S)):
        session.step()
        peak = max(peak, float(np.linalg.norm(session.cell_position(cell) - start)))
    displacement = float(np.linalg.norm(session.cell_position(cell) - start))
    expected = expected_displacement(session, cell, before)
    session.world.release()
    session.run(rest_s)
    return Push(displacement, expected, peak, float(np.abs(np.array(session.joints.position) - joints).max()))


def expected_displacement(session: Session, cell: int, before: NDArray[np.float64]) -> float:
    """Metres that the gains say a cell has come from where it rested, for what the skin feels now, at rest.

    Args:
        before: (n) rad of `turn_by_touch` then. A skin need not feel nothing there: a palm sees its own fingers.
    """
    now = np.array(session.joints.position)
    turn = turn_by_touch(session) - before
    jacobian, _ = session.gains.levers(session.robot.core, session.layout.skin_model(), now - turn / 2)
    return float(np.linalg.norm(jacobian[cell] @ turn))


def turn_by_touch(session: Session) -> NDArray[np.float64]:
    """(n) rad by which the gains say that the joints give way to all that the skin feels now, at rest.

    Joints give way by K⁻¹ τ, where τ sums over all cells (1 + w) times force and nearness on their levers
    [Cheng19 eq. 14, 16], as they are where the robot stands.
    """
    gains, robot, model = session.gains, session.robot.core, session.layout.skin_model()
    now = np.array(session.joints.position)
    torque = touch_torque(gains, robot, model, session.cell_readings_n(), session.cell_nearness(), now)
    return np.asarray(torque @ gains.joint_compliance(robot, now))


def own_give(session: Session, cell: int, force_n: float, interface: str = "position") -> float:
    """Metres that a force of so many newton moves a cell where no skin adds to it, at rest, as the robot stands now.

    J K⁻¹ Jᵀ F; by torque J K⁻¹ (M + I) M⁻¹ Jᵀ F: a force that is not felt meets the robot's own inertia M, while the
    stiffness K is that of the robot with an added inertia I.
    """
    now = np.array(session.joints.position)
    jacobian, lever = session.gains.levers(session.robot.core, session.layout.skin_model(), now)
    pressed = force_n * lever[cell]
    if interface == "torque":
        mass = np.array(_dynamics_now(session).mass_matrix).reshape(len(now), len(now))
        added = np.diag(np.broadcast_to(session.gains.values["virtual_robot"]["inertia"], now.shape))
        pressed = (mass + added) @ np.linalg.solve(mass, pressed)
    return float(np.linalg.norm(jacobian[cell] @ session.gains.joint_compliance(session.robot.core, now) @ pressed))


def lean(session: Session, cell: int, force_n: float) -> float:
    """Metres by which a robot on feet brings its weight against a level force on a cell, F h / (m g); else none.

    Its feet feel such a force, whether or not the skin does.
    """
    feet = feet_of(session.robot.core)
    if not feet:
        return 0.0
    dynamics = _dynamics_now(session)
    lowest = min(dynamics.base_from_link(session.robot.link_index(foot.link))[2, 3] for foot in feet)
    link = session.robot.link_index(session.layout.links[session.layout.link[cell]])
    height = (dynamics.base_from_link(link) @ session.layout.link_from_cell[cell])[2, 3] - lowest
    return float(force_n * height / (dynamics.mass * STANDARD_GRAVITY_MPS2))


def touch_torque(
    gains: GainSet,
    robot: RobotModel,
    model: SkinModel,
    normal_force: ArrayLike,
    proximity: ArrayLike,
    posture: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(n) Nm that the gains ask of n joints for (N, 3) newton and (N, 1) nearness of N cells [Cheng19 eq. 14, 16].

    The sum over all cells of (1 + w) times force and nearness on their levers, in a posture of (n) rad.
    """
    values = gains.values["skin"]
    _, lever = gains.levers(robot, model, posture)
    force = np.asarray(normal_force, dtype=float).sum(axis=1)
    near = np.nan_to_num(np.asarray(proximity, dtype=float).ravel())  # a skin may lack it
    pressed = force * _active(force, values["force_silent_n"], values["force_full_n"])
    seen = values["proximity_n"] * near * _active(near, values["proximity_silent"], values["proximity_full"])
    of_touch, of_nearness = gains.weights(robot, model)
    return np.asarray(((1 + of_touch) * pressed + (1 + of_nearness) * seen) @ lever)


def _active(value: NDArray[np.float64], silent: float, full: float) -> NDArray[np.float64]:
    share = np.clip((value - silent) / (full - silent), 0.0, 1.0)
    return np.asarray(share * share * (3 - 2 * share))


def press(session: Session, cell: int, force_n: float, at_m: tuple[float, float], seconds: float = 0.5) -> Press:
    """Press on a point of a cell's plane and compare what the skin feels with the contact force."""
    session.world.push(session.in_world(cell), force_n, at_m)
    _come_to_force(session, force_n)
    session.run(0.5)
    felt, contact = [], []
    for _ in range(round(seconds / PERIOD_S)):
        session.step()
        felt.append(session.felt_force_n())
        contact.append(float(session.world.contact_normal_force().sum()))
    session.world.release()
    session.run(0.5)
    return Press(float(np.mean(felt)), float(np.mean(contact)))


def _come_to_force(session: Session, force_n: float, patience_s: float = 3.0) -> None:
    for _ in range(round(patience_s / PERIOD_S)):
        session.step()
        if session.world.contact_normal_force().sum() >= 0.9 * force_n:
            return
    raise SessionError(f"the hand did not reach {force_n} N within {patience_s} s")


def require_cells_on(layout: Layout, link: str) -> None:
    """Raise UnknownNameError if the link carries no cells."""
    if link not in layout.links:
        raise UnknownNameError("link with cells", link, layout.links)


def link_to_push(robot: Robot, gains: GainSet, layout: Layout) -> str:
    """The outermost link with many cells that give way well, at home: a push there moves the robot as its gains say."""
    good = _gives_way(robot, gains, layout)
    count = np.bincount(layout.link[good], minlength=len(layout.links))
    joints = [int(robot.core.link_joints[robot.link_index(link)]) for link in layout.links]
    depth = [np.count_nonzero(robot.model.supports[joint + 1].tolist()) for joint in joints]
    many = count >= 0.4 * count.max()
    return str(layout.links[int(np.argmax(np.where(many, depth, -1)))])


def _gives_way(robot: Robot, gains: GainSet, layout: Layout) -> NDArray[np.bool_]:
    """(N,) cells that a newton moves by nearly what the gains state; others lack a lever or reach a bound."""
    model = layout.skin_model()
    jacobian, lever = gains.levers(robot.core, model)
    turn = lever @ gains.joint_compliance(robot.core)
    moved = np.linalg.norm(np.einsum("cij,cj->ci", jacobian, turn), axis=1)
    give = (1 + gains.force_weights(robot.core, model)) * moved
    aside = np.einsum("cj,cj->c", lever, turn) / np.maximum(moved, 1e-12)
    # A cell that moves aside rather than away from the hand lets it slip to another lever.
    score = give * aside
    good = np.asarray(score >= 0.8 * score.max())
    free = good & _within_reach(robot, gains.home, layout, good)
    return free if free.any() else good


def _within_reach(
    robot: Robot, posture: NDArray[np.float64], layout: Layout, cells: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """(N,) which of the cells (N,) a hand reaches along their normals: no other link is in its way.

    Between the jaws of a gripper or on the inner side of a thigh it would push both sides.
    """
    poses = robot.base_from_link(posture)
    points = [on_link @ poses[row, :3, :3].T + poses[row, :3, 3] for row, on_link in _surfaces(robot)]
    links = np.concatenate([np.full(len(on_link), row) for row, on_link in _surfaces(robot)])
    surface = np.concatenate(points)
    reached = cells.copy()
    for cell in np.flatnonzero(cells):
        row = robot.link_index(layout.links[layout.link[cell]])
        pose = poses[row] @ layout.link_from_cell[cell]
        away = surface[links != row] - pose[:3, 3]
        height = away @ pose[:3, 2]
        aside = np.linalg.norm(away - height[:, None] * pose[:3, 2], axis=1)
        reached[cell] = not ((height > 0.0) & (height < HAND_WAY_M) & (aside < HAND_WIDTH_M)).any()
    return reached


@lru_cache(maxsize=4)
def _surfaces(robot: Robot) -> list[tuple[int, NDArray[np.float64]]]:
    """(row, (K, 3) m) of each link that has a body: points drawn on it, in its own frame."""
    generator = np.random.default_rng(0)
    found = []
    for link in robot.links_with("collision"):
        mesh = robot.link_mesh(link)
        count = int(np.clip(mesh.area / SURFACE_POINT_M2, 50, 5000))
        points = trimesh.sample.sample_surface(mesh, count, seed=generator)[0]
        found.append((robot.link_index(link), np.asarray(points)))
    return found


def pushed_cell(session: Session, link: str) -> int:
    """The cell of a link that a person would push: it gives way, lies inside its patch, and faces the most sideways."""
    layout = session.layout
    require_cells_on(layout, link)
    on_link = layout.link == layout.links.index(link)
    neighbours = (layout.neighbours[:, :, 0] >= 0).sum(axis=1)
    good = on_link & _gives_way(session.robot, session.gains, layout)
    on_link = good if good.any() else on_link
    inside = neighbours == neighbours[on_link].max()
    sideways = 1.0 - np.abs(session.world.base_from_cell()[session.world_cells, 2, 2])
    return int(np.argmax(np.where(on_link & inside, sideways, -1.0)))


def bearable_force(session: Session, cell: int, share: float = 0.5) -> float:
    """Newton against a cell's normal that the driven joints can hold where the robot stands, with a share of their
    effort."""
    robot = session.robot.core
    now = np.array(session.joints.position)
    dynamics = _dynamics_now(session)
    jacobian, _ = session.gains.levers(robot, session.layout.skin_model(), now)
    normal = session.world.base_from_cell()[session.in_world(cell), :3, 2]
    effort = np.asarray(robot.effort_limit)
    driven = effort > 0
    lever = np.abs(normal @ jacobian[cell])[driven]
    spare = (effort - np.abs(np.array(dynamics.nonlinear_effects)))[driven]
    return float(np.min(share * np.maximum(spare, 0.0) / np.maximum(lever, 1e-9)))


def _dynamics_now(session: Session) -> RobotDynamics:
    """Of the robot where it stands, at rest."""
    now = np.array(session.joints.position)
    dynamics = RobotDynamics(session.robot.core)
    dynamics.update(now, np.zeros_like(now))
    return dynamics


def reached_cells(session: Session, cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(N,) which of the cells (N,) a hand reaches where the robot stands; all of them if it reaches none."""
    reached = _within_reach(session.robot, np.array(session.joints.position), session.layout, cells)
    return reached if reached.any() else cells


def is_reached(session: Session, cell: int) -> bool:
    """Whether a hand reaches the cell where the robot stands: nothing of the robot is in its way."""
    only = np.arange(len(session.layout)) == cell
    return bool(_within_reach(session.robot, np.array(session.joints.position), session.layout, only)[cell])


def seam_of(layout: Layout, cell: int) -> tuple[float, float]:
    """(x, y) metres in the cell frame: the hinge shared with a neighbour; the middle of a cell without one."""
    joined = np.flatnonzero(layout.neighbours[cell, :, 0] >= 0)
    if not len(joined):
        return 0.0, 0.0
    x, y = PORT_POINTS_M[joined[0]]
    return float(x), float(y)


def flat_seam(session: Session, link: str) -> tuple[int, tuple[float, float]] | None:
    """A cell of a link beside a seam where no cell within a hand's reach is folded, and (x, y) metres of that seam in
    its frame; None where the skin bends everywhere.

    On a ridge the sum of the cells' forces is less than the contact force, since each feels along its own normal alone.
    """
    layout = session.layout
    on_link = np.flatnonzero(reached_cells(session, layout.link == layout.links.index(link)))
    pose = layout.link_from_cell[on_link]
    sideways = 1.0 - np.abs(session.world.base_from_cell()[session.world_cells[on_link], 2, 2])
    found, best = None, -1.0
    for row, cell in enumerate(on_link):
        for port in np.flatnonzero(np.isin(layout.neighbours[cell, :, 0], on_link)):
            at = PORT_POINTS_M[port]
            point = pose[row, :3, 3] + pose[row, :3, :2] @ at
            near = np.linalg.norm(pose[:, :3, 3] - point, axis=1) < SEAM_REACH_M
            if (pose[near, :3, 2] @ pose[row, :3, 2]).min() > FLAT and sideways[row] > best:
                found, best = (int(cell), (float(at[0]), float(at[1]))), float(sideways[row])
    return found


def edge_of_patch(session: Session, link: str) -> tuple[int, tuple[float, float]]:
    """A cell of a link at the edge of its patch, and (x, y) metres in its frame, two thirds of the way to that edge."""
    layout = session.layout
    free = layout.neighbours[:, :, 0] < 0
    # Two free ports on one side: nothing but the bare link lies beyond that side.
    sides = np.stack([free[:, 0] & free[:, 1], free[:, 2] & free[:, 3]], axis=1)
    sideways = 1.0 - np.abs(session.world.base_from_cell()[session.world_cells, 2, 2])
    edges = reached_cells(session, (layout.link == layout.links.index(link)) & sides.any(axis=1))
    cell = int(np.argmax(np.where(edges, sideways, -1.0)))
    direction = 1.0 if sides[cell, 0] else -1.0
    return cell, (direction * 0.008, 0.0)
