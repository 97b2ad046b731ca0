# SPDX-License-Identifier: Apache-2.0
"""A thing of the world, as users look at it and act on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin.world import bodies
from robotskin.world.things import PathSpec, ThingSpec

if TYPE_CHECKING:
    from robotskin.world.world import World


class Thing:
    """One thing of the scene; of one with parts, its first piece stands for it."""

    def __init__(self, world: World, spec: ThingSpec) -> None:
        self._world = world
        self.spec = spec
        self.pieces = tuple(
            index
            for index, piece in enumerate(world.scene.pieces, start=len(world.scene.hands))
            if piece.thing == spec.name
        )
        """Its places in the world's list of objects."""

    @property
    def name(self) -> str:
        """As the scene calls it."""
        return self.spec.name

    @property
    def _body(self) -> int:
        return int(self._world.scene.object_body[self.pieces[0]])

    @property
    def world_from_thing(self) -> NDArray[np.float64]:
        """(4, 4) metres, as of the last physics step."""
        return self.world_from_piece(0)

    def world_from_piece(self, number: int) -> NDArray[np.float64]:
        """(4, 4) metres, of a piece in the order of the scene; at the beginning each has the frame of the thing."""
        with self._world._lock:
            data = self._world.scene.data
            body = int(self._world.scene.object_body[self.pieces[number]])
            result = np.eye(4)
            result[:3, :3] = data.xmat[body].reshape(3, 3)
            result[:3, 3] = data.xpos[body]
        return result

    @property
    def position_m(self) -> NDArray[np.float64]:
        """(3,) metres, its origin in the world."""
        with self._world._lock:
            return np.array(self._world.scene.data.xpos[self._body])

    @property
    def velocity_m_s(self) -> NDArray[np.float64]:
        """(3,) m/s, of its origin in the world."""
        with self._world._lock:
            motion = np.zeros(6)
            scene = self._world.scene
            mujoco.mj_objectVelocity(scene.model, scene.data, mujoco.mjtObj.mjOBJ_XBODY, self._body, motion, 0)
        return motion[3:]

    @property
    def mass_kg(self) -> float:
        """All parts together."""
        with self._world._lock:
            return float(sum(self._world.scene.model.body_mass[self._world.scene.object_body[i]] for i in self.pieces))

    @property
    def skin_force_n(self) -> float:
        """Newton, MuJoCo's normal contact force on all cells."""
        return float(self._world.contact_normal_force()[list(self.pieces)].sum())

    def push(self, force_n: ArrayLike) -> None:
        """Let a force (3,) newton, along the world's axes, act on its centre of mass until another one is given."""
        from robotskin.world.world import WorldError

        force = np.asarray(force_n, dtype=float)
        if force.shape != (3,) or not np.isfinite(force).all():
            raise WorldError(f"push of {self.name} with {force_n!r} N: must be three finite numbers")
        with self._world._lock:
            self._world.scene.data.xfrc_applied[self._body, :3] = force

    def let_go(self) -> None:
        """Hold it no longer. Raises WorldError for a thing that is not `held`."""
        from robotskin.world.world import WorldError

        if self.spec.moves != "held":
            raise WorldError(
                f"let {self.name} go: it moves as {self.spec.moves!r}; only one that is 'held' can be let go"
            )
        with self._world._lock:
            scene = self._world.scene
            scene.data.eq_active[scene.model.equality(scene.model.body(self._body).name).id] = 0

    def follow(self, path: PathSpec) -> None:
        """Go another way from now on; `begins_s` counts from now. Raises WorldError for what is on no path."""
        from robotskin.world.world import WorldError

        carrier = self._world._carrier.get(self.name)
        if carrier is None:
            raise WorldError(
                f"path of {self.name}: it moves as {self.spec.moves!r}; only one with 'path' follows a path"
            )
        begins_s = self._world.time_s + path.begins_s
        with self._world._lock:
            self._world.body.carrier_follow(carrier, bodies.waypoints(path), path.smooth, path.repeats, begins_s)

    def put(self, position_m: ArrayLike, rotation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        """Put a free thing at (3) m in the world's frame, at rest. Raises WorldError for one that is not `free`."""
        from robotskin.world.world import WorldError

        if self.spec.moves != "free":
            raise WorldError(f"put {self.name} elsewhere: it moves as {self.spec.moves!r}; it must be 'free'")
        with self._world._lock:
            model, data = self._world.scene.model, self._world.scene.data
            joint = int(model.body_jntadr[self._body])
            data.qpos[model.jnt_qposadr[joint] :][:3] = np.asarray(position_m, dtype=float)
            data.qpos[model.jnt_qposadr[joint] :][3:7] = bodies.quaternion(rotation_deg)
            data.qvel[model.jnt_dofadr[joint] :][:6] = 0
