# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench control`, the peer: the same fixed-base problem as one flat weighted programme, here and by TSID.

Both hands of Talos in six directions and a posture, weighted; limits of torque and, over a horizon, of velocity; at
rest, where no library's drift terms matter. Each tick is timed from Python, from the joint positions to the torque:
dynamics, Jacobians, errors, programme. TSID runs in a Python environment of its own (docs/control.md says how it is
made) and gets the problem as a file; where there is none, its figures are absent.
"""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
from numpy.typing import NDArray

from robotskin import robots
from robotskin.errors import RobotskinError
from robotskin.model import RobotDynamics
from robotskin.robots.gains import GainSet
from robotskin.tasks import QuadraticFusion, QuadraticLimits
from robotskin_lab.bench.control_ticks import time_figures

Array = NDArray[np.float64]
ROBOT, HANDS = "talos", ("gripper_left_base_link", "gripper_right_base_link")
POSITIONS = 64
HAND_WEIGHT, POSTURE_WEIGHT = 1.0, 0.1
STIFFNESS, POSTURE_STIFFNESS = 400.0, 100.0  # 1/s^2
TORQUE_SHARE, HORIZON_S = 0.25, 0.02
PYTHON_VARIABLE = "ROBOTSKIN_TSID_PYTHON"
PEER = Path(__file__).with_name("peer_tsid.py")


def peer_figures(seed: int, ticks: int, tsid_python: str = "") -> dict[str, float]:
    """Ticks of the flat programme, and TSID's and the agreement of both where `tsid_python` (or the environment
    variable ROBOTSKIN_TSID_PYTHON) names a Python that has TSID.
    """
    problem = FlatProblem(np.random.default_rng(seed))
    torques, limited = problem.answers()
    figures = time_figures("flat_qp_tick", problem.times(ticks) / 1e3)
    figures["flat_qp_limited_share"] = limited
    interpreter = tsid_python or os.environ.get(PYTHON_VARIABLE, "")
    if interpreter:
        answer = _ask_tsid(interpreter, problem.described() | {"ticks": ticks})
        theirs = np.array(answer["torques"])
        figures |= time_figures("peer_tsid_tick", np.array(answer["times_ns"]) / 1e3)
        figures["flat_qp_over_tsid"] = figures["flat_qp_tick_median_us"] / figures["peer_tsid_tick_median_us"]
        figures["flat_qp_tsid_difference"] = float(np.abs(torques - theirs).max() / np.abs(theirs).max())
    return figures


class FlatProblem:
    """Positions around a closed path, references at its middle, and our tick."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.robot = robots.load(ROBOT)
        self.core, self.home = self.robot.core, GainSet.load(ROBOT).home
        n = self.core.joint_count
        room = np.minimum(np.minimum(self.home - self.core.lower, self.core.upper - self.home) / 2, 0.2)
        turn = rng.uniform(0, 2 * np.pi, n)
        around = 2 * np.pi * np.arange(POSITIONS) / POSITIONS
        self.positions = [self.home + room * np.sin(angle + turn) for angle in around]
        self.rest, self.identity = np.zeros(n), np.eye(n)
        self.dynamics = RobotDynamics(self.core)
        self.dynamics.update(self.home, self.rest)
        self.hands = [self.core.link_index(name) for name in HANDS]
        self.references = [self.dynamics.base_from_link(hand) for hand in self.hands]
        self.limits = QuadraticLimits.of(self.core)
        self.limits.lower, self.limits.upper = [-np.inf] * n, [np.inf] * n
        needed = 1.5 * np.abs(self.dynamics.gravity_torque)
        self.limits.torque = np.maximum(TORQUE_SHARE * np.array(self.limits.torque), needed).tolist()
        self.limits.horizon_s = HORIZON_S
        self.fusion = QuadraticFusion(n, 6 * len(HANDS) + n, 1, self.limits)

    def tick(self, position: Array) -> Array:
        """(n,) Nm: the state in, the torque out."""
        dynamics = self.dynamics
        dynamics.update(position, self.rest)
        terms = [(POSTURE_WEIGHT, self.identity, POSTURE_STIFFNESS * (self.home - position))]
        for link, reference in zip(self.hands, self.references, strict=True):
            place = dynamics.base_from_link(link)
            error = np.empty(6)  # along the axes of the base; TSID's are the hand's, which changes no square
            error[:3] = reference[:3, 3] - place[:3, 3]
            error[3:] = place[:3, :3] @ pinocchio.log3(place[:3, :3].T @ reference[:3, :3])
            terms.append((HAND_WEIGHT, dynamics.link_jacobian(link), STIFFNESS * error))
        return self.fusion.fuse_weighted(dynamics, position, self.rest, dynamics.nonlinear_effects, terms)

    def answers(self) -> tuple[Array, float]:
        """(positions, n) Nm, and the share of ticks that met a limit."""
        torques, limited = [], 0
        for position in self.positions:
            torques.append(self.tick(position))
            limited += self.fusion.constrained
        return np.array(torques), limited / len(self.positions)

    def times(self, ticks: int) -> NDArray[np.int64]:
        """(ticks, 2) nanoseconds on the clock and of the processor."""
        times = np.empty((ticks, 2), dtype=np.int64)
        for index in range(ticks):
            position = self.positions[index % POSITIONS]
            wall, processor = time.perf_counter_ns(), time.thread_time_ns()
            self.tick(position)
            times[index] = time.perf_counter_ns() - wall, time.thread_time_ns() - processor
        return times

    def described(self) -> dict[str, Any]:
        """All that TSID needs to know, ready for JSON."""
        return {
            "urdf": self.robot.urdf,
            "joints": list(self.core.joint_names),
            "positions": [position.tolist() for position in self.positions],
            "posture": self.home.tolist(),
            "posture_weight": POSTURE_WEIGHT,
            "posture_stiffness": POSTURE_STIFFNESS,
            "stiffness": STIFFNESS,
            "damping": 2 * STIFFNESS**0.5,
            "frames": [
                {"name": name, "weight": HAND_WEIGHT, "base_from_frame": reference.tolist()}
                for name, reference in zip(HANDS, self.references, strict=True)
            ],
            "torque": list(self.limits.torque),
            "velocity": list(self.limits.velocity),
            "horizon_s": HORIZON_S,
        }


def _ask_tsid(interpreter: str, problem: dict[str, Any]) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        urdf, asked, answered = (Path(folder) / name for name in ("robot.urdf", "problem.json", "answer.json"))
        urdf.write_text(problem["urdf"])
        asked.write_text(json.dumps(problem | {"urdf": str(urdf)}))
        # The other environment must not find this one's modules.
        environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
        command = [interpreter, str(PEER), str(asked), str(answered)]
        try:
            run = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
        except OSError as error:
            raise RobotskinError(f"TSID's Python {interpreter} cannot be run: {error.strerror}") from error
        if run.returncode != 0:
            raise RobotskinError(f"TSID in {interpreter} gave no answer: {run.stderr.strip()[-500:]}")
        answer: dict[str, Any] = json.loads(answered.read_text())
        return answer
