# SPDX-License-Identifier: Apache-2.0
"""Ticks of TSID, run by `control_peer.py` in a Python environment that has it.

Usage: PYTHON peer_tsid.py PROBLEM.json ANSWER.json; answers times and torques. One flat weighted programme a tick:
computeProblemData, eiquadprog, the torques of its answer. Stands alone: imports nothing of robotskin.
"""

import importlib
import json
import sys
import time
from typing import Any

import numpy as np
import pinocchio as pin


def load_tsid() -> Any:
    """TSID's bindings; its older wheels have them in a submodule alone."""
    try:
        return importlib.import_module("tsid.tsid_pywrap")
    except ModuleNotFoundError:
        return importlib.import_module("tsid")


class Peer:
    """TSID's inverse dynamics with the tasks, weights and limits of a problem."""

    def __init__(self, problem: dict[str, Any]) -> None:
        tsid = load_tsid()
        self.robot = tsid.RobotWrapper(problem["urdf"], pin.StdVec_StdString(), False)
        order = [self.robot.model().getJointId(name) - 1 for name in problem["joints"]]
        if order != list(range(self.robot.nv)):
            raise SystemExit(f"TSID orders the joints as {order}")
        self.formulation = tsid.InverseDynamicsFormulationAccForce("tsid", self.robot, False)
        rest = np.zeros(self.robot.nv)
        self.formulation.computeProblemData(0.0, np.array(problem["positions"][0]), rest)
        self.kept: list[Any] = []
        for frame in problem["frames"]:
            task = tsid.TaskSE3Equality(frame["name"], self.robot, frame["name"])
            task.setKp(np.full(6, problem["stiffness"]))
            task.setKd(np.full(6, problem["damping"]))
            reference = tsid.TrajectorySample(12, 6)
            place = np.array(frame["base_from_frame"])
            reference.value(tsid.SE3ToVector(pin.SE3(place[:3, :3], place[:3, 3])))
            task.setReference(reference)
            self._motion(task, frame["weight"], level=1)
        posture = tsid.TaskJointPosture("posture", self.robot)
        posture.setKp(np.full(self.robot.nv, problem["posture_stiffness"]))
        posture.setKd(np.full(self.robot.nv, problem["damping"]))
        reference = tsid.TrajectorySample(self.robot.nv)
        reference.value(np.array(problem["posture"]))
        posture.setReference(reference)
        self._motion(posture, problem["posture_weight"], level=1)
        torque = np.array(problem["torque"])
        actuation = tsid.TaskActuationBounds("actuation", self.robot)
        actuation.setBounds(-torque, torque)
        self.kept.append(actuation)
        self.formulation.addActuationTask(actuation, 1.0, 0, 0.0)
        bounds = tsid.TaskJointBounds("bounds", self.robot, problem["horizon_s"])
        bounds.setVelocityBounds(-np.array(problem["velocity"]), np.array(problem["velocity"]))
        bounds.setAccelerationBounds(np.full(self.robot.nv, -1e6), np.full(self.robot.nv, 1e6))
        self._motion(bounds, 1.0, level=0)
        self.solver = tsid.SolverHQuadProgFast("programme")
        self.solver.resize(self.formulation.nVar, self.formulation.nEq, self.formulation.nIn)

    def _motion(self, task: Any, weight: float, level: int) -> None:
        self.kept.append(task)
        self.formulation.addMotionTask(task, weight, level, 0.0)

    def tick(self, position: np.ndarray, rest: np.ndarray) -> tuple[bool, np.ndarray]:
        """Torque (n) Nm, and whether TSID's solver found it."""
        data = self.formulation.computeProblemData(0.0, position, rest)
        answer = self.solver.solve(data)
        return answer.status == 0, self.formulation.getActuatorForces(answer)


def main() -> None:
    """Answer with (ticks, 2) nanoseconds on the clock and of the processor, and the torque of each position."""
    with open(sys.argv[1]) as file:
        problem = json.load(file)
    peer = Peer(problem)
    positions = [np.array(position) for position in problem["positions"]]
    rest = np.zeros(peer.robot.nv)
    torques = []
    for position in positions:
        solved, torque = peer.tick(position, rest)
        if not solved:
            raise SystemExit("TSID's solver found no answer")
        torques.append(torque.tolist())
    times = []
    for tick in range(problem["ticks"]):
        position = positions[tick % len(positions)]
        wall, processor = time.perf_counter_ns(), time.thread_time_ns()
        peer.tick(position, rest)
        times.append([time.perf_counter_ns() - wall, time.thread_time_ns() - processor])
    with open(sys.argv[2], "w") as file:
        json.dump({"times_ns": times, "torques": torques, "versions": {"pinocchio": pin.__version__}}, file)


if __name__ == "__main__":
    main()
