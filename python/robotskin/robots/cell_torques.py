# SPDX-License-Identifier: Apache-2.0
"""What the cells of a skin must know to compute their torques themselves: limbs, chains and gains in their integers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin import firmware
from robotskin.robots.chains import Chain, ChainError
from robotskin.robots.robot import Robot
from robotskin.skin import SkinModel
from robotskin.tasks import SkinGains

LIMBS_MAX = 16
"""Of one section-unit group."""

_STEP = {name: step for name, _, _, step, _ in firmware.CHANNELS}


@dataclass(frozen=True)
class Limb:
    """Cells whose torques are summed into one vector: those of one section-unit group on one chain of joints."""

    group: int
    number: int
    """0 to 15, of the group."""
    chain: Chain
    """To the outermost link; every other cell's chain is its beginning."""
    cells: tuple[int, ...]
    """Indices in the skin model."""

    @property
    def joints(self) -> tuple[int, ...]:
        """(n,) indices of the robot's joints."""
        return self.chain.joints


@dataclass(frozen=True)
class CellTorques:
    """The limbs of a skin of N cells, and what each cell has to be told."""

    limbs: tuple[Limb, ...]
    parameters: dict[int, firmware.TorqueParameters]
    """By cell; the others sit on the base, which no joint moves."""
    step_bits: int

    @classmethod
    def of(
        cls, robot: Robot, skin: SkinModel, gains: SkinGains, step_bits: int = firmware.TORQUE_STEP_BITS
    ) -> CellTorques:
        """The torques that the host's skin task would compute with the same gains.

        `step_bits`: the vectors count in steps of 2^-step_bits Nm, and hold 32767 of them.
        Raises ChainError for a link with too many joints below it, for cells too far from a joint, and for a group of
        more than 16 limbs.
        """
        chains: dict[str, Chain] = {}
        for name in sorted({skin.link_names[index] for index in skin.link}):
            if robot.core.link_joints[robot.link_index(name)] >= 0:
                chains[name] = Chain.to(robot, name)
        limbs: list[Limb] = []
        parameters = {}
        groups = skin.key >> 16
        for group in sorted({int(value) for value in groups}):
            worn: dict[tuple[int, ...], Chain] = {}
            for cell in np.flatnonzero(groups == group):
                chain = chains.get(skin.link_names[skin.link[cell]])
                if chain is not None:
                    worn.setdefault(chain.joints, chain)
            outermost = [
                joints
                for joints in sorted(worn)
                if not any(other != joints and other[: len(joints)] == joints for other in worn)
            ]
            if len(outermost) > LIMBS_MAX:
                raise ChainError(f"section unit group {group} has {len(outermost)} limbs: {LIMBS_MAX} can be")
            cells: dict[tuple[int, ...], list[int]] = {joints: [] for joints in outermost}
            for cell in np.flatnonzero(groups == group):
                chain = chains.get(skin.link_names[skin.link[cell]])
                if chain is None:
                    continue
                joints = next(joints for joints in outermost if joints[: len(chain.joints)] == chain.joints)
                cells[joints].append(int(cell))
                parameters[int(cell)] = firmware.TorqueParameters(
                    chain=chain.of_cell(skin.link_from_cell[cell]),
                    gains=touch_gains(gains, int(cell)),
                    limb=outermost.index(joints),
                    step_bits=step_bits,
                    slide=min(32767, int(np.ceil(chain.slide_m * 2**firmware.LENGTH_BITS))),
                )
            for number, joints in enumerate(outermost):
                limbs.append(Limb(group, number, worn[joints], tuple(cells[joints])))
        return cls(tuple(limbs), parameters, step_bits)

    @property
    def step(self) -> float:
        """Nm, or N where a joint slides, of one count of the vectors."""
        return 2.0**-self.step_bits

    @property
    def places(self) -> list[tuple[int, int, tuple[int, ...]]]:
        """(section-unit group, limb, indices of the robot's joints) of each limb."""
        return [(limb.group, limb.number, limb.joints) for limb in self.limbs]

    @property
    def codes(self) -> list[tuple[int, int, list[tuple[int, str]]]]:
        """How the joints of each limb are told to its cells, as `DatagramInput.take_skin_computed_torque` takes it."""
        return [(limb.group, limb.number, limb.chain.code_kinds) for limb in self.limbs]

    def newton_metres(self, limb: Limb, vector: ArrayLike) -> NDArray[np.float64]:
        """(n,) Nm, or N where a joint slides, from a limb's vector as the driver hands it out."""
        return np.asarray(vector, dtype=float)[: len(limb.joints)] * self.step


def touch_gains(gains: SkinGains, cell: int) -> firmware.TouchGains:
    """The gains of one cell in counts."""
    force = gains.force_silent[cell], gains.force_full[cell], gains.force_weight[cell]
    proximity = gains.proximity_silent[cell], gains.proximity_full[cell], gains.proximity_weight[cell]
    return firmware.TouchGains(
        _sense(*force, step=_STEP["force_1"], most=3 * 1023), _sense(*proximity, step=_STEP["proximity"], most=65535)
    )


def _sense(silent: float, full: float, weight: float, step: float, most: int) -> tuple[int, int, int, int]:
    """Silent, full (counts), weight and its fraction bits; `most` counts are the end of the range."""
    low = min(round(silent / step), most - 1)
    high = min(max(round(full / step), low + 1), 65535)
    asked = weight * step
    bits = 30 if asked == 0 else int(np.clip(np.floor(np.log2(65535 / asked)), 0, 30))
    return low, high, min(round(asked * 2.0**bits), 65535), bits
