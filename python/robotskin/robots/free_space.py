# SPDX-License-Identifier: Apache-2.0
"""Where a robot may move while it babbles: inside its joint limits, clear of itself and of its surroundings."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pinocchio
from numpy.typing import NDArray

from robotskin.robots import Robot

Array = NDArray[np.float64]

DRAWN, BUILT_CLOSE = 20, 0.8
"""Two links are built close where they come closer than the margin in such a share of drawn postures."""


class FreeSpace:
    """Postures of a robot that touch nothing.

    Links are taken as their convex hulls (Coal), with `margin_m` of room around them for the skin. Not tested are links
    joined by a joint, and pairs whose hulls already overlap at the neutral posture. Pairs built closer than the margin,
    as the links of a wrist, and those closer than it at `home` (n), such as the thighs of a humanoid, need only not
    touch. The surroundings are the half space below `floor_m` (base frame z;
    None: nothing around), which only links that can move must avoid.
    """

    def __init__(
        self,
        robot: Robot,
        margin_m: float = 0.02,
        floor_m: float | None = None,
        limit_margin_rad: float = 0.1,
        home: Array | None = None,
    ) -> None:
        self.robot, self.floor_m = robot, floor_m
        model = robot.model
        self._data = model.createData()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "robot.urdf"
            path.write_text(robot.urdf)
            self._geometry = pinocchio.buildGeomFromUrdf(model, str(path), pinocchio.GeometryType.COLLISION)
        for body in self._geometry.geometryObjects:
            if hasattr(body.geometry, "buildConvexRepresentation"):
                body.geometry.buildConvexRepresentation(False)
                body.geometry = body.geometry.convex
        self._geometry.addAllCollisionPairs()
        neighbours = {(model.parents[joint], joint) for joint in range(1, model.njoints)}
        for pair in list(self._geometry.collisionPairs):
            joints = sorted(self._geometry.geometryObjects[index].parentJoint for index in (pair.first, pair.second))
            if joints[0] == joints[1] or tuple(joints) in neighbours:
                self._geometry.removeCollisionPair(pair)
        self._state = self._geometry.createData()
        touching = self._met(robot.neutral, 0.0)
        for index, pair in reversed(list(enumerate(self._geometry.collisionPairs))):
            if touching[index]:
                self._geometry.removeCollisionPair(pair)
        self._state = self._geometry.createData()
        random = np.random.default_rng(0)
        drawn = [self._met(robot.random_posture(random), margin_m) for _ in range(DRAWN)]
        built_close = self._met(robot.neutral, margin_m) & (np.mean(drawn, axis=0) > BUILT_CLOSE)
        if home is not None:
            built_close |= self._met(home, margin_m)
        self._set_margins(np.where(built_close, 0.0, margin_m))
        self.margin_m = margin_m
        room = np.minimum(limit_margin_rad, 0.1 * (robot.upper - robot.lower))
        self.lower, self.upper = robot.lower + room, robot.upper - room

    def _set_margins(self, margin_m: Array) -> None:
        for request, margin in zip(self._state.collisionRequests, margin_m, strict=True):
            request.security_margin = float(margin)

    def _met(self, q: Array, margin_m: float) -> NDArray[np.bool_]:
        """(pairs) which pairs come closer than a margin in a posture (n)."""
        self._set_margins(np.full(len(self._geometry.collisionPairs), margin_m))
        pinocchio.computeCollisions(self.robot.model, self._data, self._geometry, self._state, q, False)
        return np.array([result.isCollision() for result in self._state.collisionResults], dtype=bool)

    def why_not(self, q: Array) -> str | None:
        """What is wrong with a posture (n) rad or m: a joint limit, two links, a link below the floor; None if free."""
        outside = (q < self.lower) | (q > self.upper)
        if outside.any():
            joint = int(np.argmax(outside))
            allowed = f"{self.lower[joint]:.3f} to {self.upper[joint]:.3f}"
            return f"joint {self.robot.joint_names[joint]} at {q[joint]:.3f}, allowed {allowed}"
        model = self.robot.model
        if pinocchio.computeCollisions(model, self._data, self._geometry, self._state, q, True):
            for index, pair in enumerate(self._geometry.collisionPairs):
                if self._state.collisionResults[index].isCollision():
                    first, second = (self._geometry.geometryObjects[i].name for i in (pair.first, pair.second))
                    margin = self._state.collisionRequests[index].security_margin
                    return (
                        f"{first} and {second} come closer than {margin} m" if margin else f"{first} touches {second}"
                    )
        if self.floor_m is not None:
            for body, placement in zip(self._geometry.geometryObjects, self._state.oMg, strict=True):
                if body.parentJoint == 0:
                    continue
                body.geometry.computeLocalAABB()
                lowest = placement.translation[2] + placement.rotation[2] @ np.asarray(body.geometry.aabb_center)
                # The box around the body, turned: never less than what the body takes.
                box = body.geometry.aabb_local
                lowest -= np.abs(placement.rotation[2]) @ np.array([box.width(), box.height(), box.depth()]) / 2
                if lowest < self.floor_m:
                    return f"{body.name} reaches {lowest:.3f} m, the floor is at {self.floor_m} m"
        return None

    def is_free(self, q: Array) -> bool:
        """Whether a posture (n) touches nothing."""
        return self.why_not(np.asarray(q, dtype=float)) is None

    def nearest_free(self, q: Array, tries: int = 2000) -> Array:
        """A free posture (n) near q (n) rad or m: q moved inside the limits, or else the nearest that a search finds.

        The search is the same each time. Where it finds none, q moved inside the limits is returned.
        """
        inside = np.clip(q, self.lower, self.upper)
        if self.is_free(inside):
            return inside
        random = np.random.default_rng(0)
        for spread in np.linspace(0.1, 1.5, 15):
            drawn = inside + random.normal(0.0, spread, (tries // 15, len(inside)))
            free = [one for one in np.clip(drawn, self.lower, self.upper) if self.is_free(one)]
            if free:
                return min(free, key=lambda one: float(np.abs(one - inside).sum()))
        return inside

    def path_is_free(self, start: Array, end: Array, step_rad: float = 0.05) -> bool:
        """Whether every posture on the straight line between two postures (n) is free, sampled each `step_rad`."""
        count = max(2, int(np.ceil(np.abs(end - start).max() / step_rad)) + 1)
        return all(self.is_free(start + (end - start) * share) for share in np.linspace(0.0, 1.0, count))
