# SPDX-License-Identifier: Apache-2.0
"""One robot on a fixed base, from one text: its joints, links, limits, surfaces, and its models in two libraries."""

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio
import trimesh

from robotskin.errors import InputError, UnknownNameError
from robotskin.model import RobotDynamics, RobotModel
from robotskin.robots.mujoco_model import build_spec
from robotskin.robots.repair import Mimic, Repair
from robotskin.robots.standing import Standing
from robotskin.robots.surface import link_surface

Surface = Literal["collision", "visual"]


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot of n joints with one position each and l links; `load` makes one. SI units, radians.

    Every model is built from `urdf`, so that all have the same joints in the same order (`joint_names`), the same
    placements and the same inertias. Joints a mechanism couples are joints of their own here (`mimics` tells which).
    """

    name: str
    urdf: str
    source: Path | None
    repairs: tuple[Repair, ...]
    mimics: tuple[Mimic, ...]
    core: RobotModel = field(repr=False)
    locked: dict[str, float] = field(default_factory=dict)
    """Joints that were fixed on loading, rad or m by name; they are none of `joint_names`."""
    stated_friction: dict[str, float] = field(default_factory=dict)
    """Coulomb friction, Nm or N by name of the joint, where a file of dynamics states it; a URDF's is not used."""
    standing: Standing | None = None
    """What it stands on, if it is not mounted; its first six joints then move its base and have no motor."""

    def __repr__(self) -> str:
        locked = f", {len(self.locked)} locked" if self.locked else ""
        where = f" from {self.source}" if self.source else ""
        return f"<Robot {self.name}: {self.joint_count} joints{locked}, {len(self.link_names)} links{where}>"

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The n movable joints; parents come before their children."""
        return tuple(self.core.joint_names)

    @property
    def joint_count(self) -> int:
        """The number n of movable joints."""
        return self.core.joint_count

    @property
    def link_names(self) -> tuple[str, ...]:
        """The l links, the base link first."""
        return tuple(self.core.link_names)

    @property
    def base_link(self) -> str:
        """The link that does not move; its frame is the base frame."""
        return self.core.link_names[0]

    @property
    def lower(self) -> np.ndarray:
        """(n) rad or m; -inf where a joint turns or moves without end."""
        return self.core.lower

    @property
    def upper(self) -> np.ndarray:
        """(n) rad or m; inf where a joint turns or moves without end."""
        return self.core.upper

    @property
    def joint_slides(self) -> tuple[bool, ...]:
        """Of each joint whether it slides, in metres; the others turn, in radians."""
        return tuple(kind.name == "prismatic" for kind in self.core.joint_kinds)

    @property
    def velocity_limit(self) -> np.ndarray:
        """(n) rad/s or m/s."""
        return self.core.velocity_limit

    @property
    def effort_limit(self) -> np.ndarray:
        """(n) Nm or N."""
        return self.core.effort_limit

    @property
    def rotor_inertia(self) -> dict[str, float]:
        """kg m² or kg by name of the joint, of the motors' rotors; 0 where no file of dynamics states it."""
        return dict(zip(self.joint_names, self.core.rotor_inertia.tolist(), strict=True))

    @property
    def neutral(self) -> np.ndarray:
        """(n) rad or m: zero, or the limit nearest to it."""
        return np.clip(np.zeros(self.joint_count), self.lower, self.upper)

    def random_posture(self, generator: np.random.Generator) -> np.ndarray:
        """(n) rad or m, uniform between the limits; unbounded joints between -π and π rad, or -1 and 1 m."""
        reach = np.where(self.joint_slides, 1.0, np.pi)
        lower = np.where(np.isfinite(self.lower), self.lower, -reach)
        upper = np.where(np.isfinite(self.upper), self.upper, reach)
        return generator.uniform(lower, upper)

    @cached_property
    def model(self) -> pinocchio.Model:
        """The Pinocchio model; its position and velocity indices are those of `joint_names`."""
        model = pinocchio.buildModelFromXML(self.urdf)
        model.lowerPositionLimit = self.lower
        model.upperPositionLimit = self.upper
        model.armature = self.core.rotor_inertia
        return model

    def mujoco_spec(self, *, self_collision: bool = False) -> mujoco.MjSpec:
        """A new MuJoCo spec of the robot, to which bodies, geoms and actuators may be added before compiling.

        Bodies carry the links' names, joints those of `joint_names` in their order, beginning at index 0 as long as
        nothing with joints is added before. Without `self_collision` the robot's own geoms do not meet each other.
        """
        return build_spec(self.urdf, self.joint_names, self_collision, self.rotor_inertia)

    def mujoco_model(self, *, self_collision: bool = False) -> mujoco.MjModel:
        """The compiled MuJoCo model of the robot alone."""
        return self.mujoco_spec(self_collision=self_collision).compile()

    def base_from_link(self, q: np.ndarray) -> np.ndarray:
        """(l, 4, 4) placements of all links, in the order of `link_names`, at the positions q (n) rad or m."""
        dynamics = RobotDynamics(self.core)
        q = np.ascontiguousarray(q, dtype=float)
        if q.shape != (self.joint_count,):
            raise InputError(
                f"q of shape {q.shape}: {self.name} has {self.joint_count} joints, so ({self.joint_count},)"
            )
        dynamics.update(q, np.zeros_like(q))
        base_from_joint = np.concatenate([np.eye(4)[None], dynamics.base_from_joint])
        return base_from_joint[self.core.link_joints + 1] @ self.core.joint_from_link

    def link_index(self, link: str) -> int:
        """Place of a link in `link_names`; raises UnknownNameError."""
        if link not in self.link_names:
            raise UnknownNameError(f"link of {self.name}", link, self.link_names)
        return self.link_names.index(link)

    def joint_index(self, joint: str) -> int:
        """Place of a joint in `joint_names`; raises UnknownNameError."""
        if joint not in self.joint_names:
            raise UnknownNameError(f"joint of {self.name}", joint, self.joint_names)
        return self.joint_names.index(joint)

    def links_with(self, surface: Surface) -> tuple[str, ...]:
        """The links that have a surface of this kind."""
        return tuple(name for name in self.link_names if self._links[name].find(f"{surface}/geometry") is not None)

    def link_mesh(self, link: str, surface: Surface = "collision") -> trimesh.Trimesh:
        """The surface of a link in its frame, in metres, all its parts in one mesh.

        Raises UnknownNameError if there is no such link, or none that has a surface of this kind.
        """
        self.link_index(link)
        if link not in self.links_with(surface):
            raise UnknownNameError(f"link of {self.name} with a {surface} surface", link, self.links_with(surface))
        return link_surface(self._links[link], surface)

    @cached_property
    def _links(self) -> dict[str, ElementTree.Element]:
        return {link.get("name", ""): link for link in ElementTree.fromstring(self.urdf).findall("link")}
