# SPDX-License-Identifier: Apache-2.0
"""Which links of well-known robots are covered, with how many cells and under which rules."""

from dataclasses import dataclass, field
from math import cos, radians, sin

from robotskin.layout.places import Area, Rules

UR5_LINKS = ("shoulder_link", "upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link")
DUAL_ARM_LINKS = tuple(f"{side}_{link}" for side in ("left", "right") for link in UR5_LINKS)
PANDA_LINKS = tuple(f"panda_link{number}" for number in range(1, 8))
TALOS_LIMB_LINKS = (
    *(f"arm_{{side}}_{number}_link" for number in range(1, 6)),
    *(f"leg_{{side}}_{number}_link" for number in (1, 2, 3, 4, 6)),
)
HAND_LINKS = ("palm_link", *(f"link_{number}.0" for number in (1, 2, 3, 5, 6, 7, 9, 10, 11, 12, 13, 14, 15)))
FINGER_TIPS = tuple(f"link_{number}.0_tip" for number in (3, 7, 11, 15))

ON_NARROW_LINKS = Rules(clearance=0.001, least_foam=0.0009, most_overhang=0.85, least_patch=1)
"""A finger is narrower than a cell: most of a cell's back may stand off, and a cell may be alone."""
ON_A_PALM = Rules(clearance=0.001, most_overhang=0.25)


@dataclass(frozen=True)
class Plan:
    """links: names; cells: in all; rules: of places, other ones for some links; areas: parts of links that get their
    cells first; tries: first cells of each patch; robot: if it is not that of the plan's name; worn: a finished skin of
    further links that is taken as it is."""

    links: tuple[str, ...]
    cells: int
    rules: Rules = field(default_factory=Rules)
    link_rules: dict[str, Rules] = field(default_factory=dict)
    areas: tuple[Area, ...] = ()
    tries: int = 3
    robot: str = ""
    worn: str = ""


ON_A_PAD = Rules(clearance=0.0005, most_overhang=0.45, least_patch=1)
"""Pads meet in the middle, skin on skin."""


def pads(prefix: str = "", cells: int = 5) -> tuple[Area, ...]:
    """The inner faces of a gripper's two pads: a cell in the middle of each, the others about it."""
    return tuple(
        Area(f"{prefix}{side}_pad", cells, (0.0, 0.0, 1.0), 10.0, (0.0, 0.0, 0.0), ON_A_PAD)
        for side in ("left", "right")
    )


ON_A_FINGERS_FRONT = Rules(clearance=-0.1, least_foam=0.0009, most_overhang=0.9, least_patch=1)
"""Pads may meet those of the next link where a finger closes further than any grasp does."""
PALMAR = (1.0, 0.0, 0.0)
"""Where the front of every link of the Allegro hand looks."""


def _tilted(angle_deg: float) -> tuple[float, float, float]:
    """From the palm's side towards the finger's end."""
    return (cos(radians(angle_deg)), 0.0, sin(radians(angle_deg)))


def _on_front(link: str, cells: int, height_m: float) -> Area:
    return Area(link, cells, PALMAR, 15.0, (0.012, 0.0, height_m), ON_A_FINGERS_FRONT)


def _on_tip(link: str, tilt_deg: float) -> Area:
    towards = _tilted(tilt_deg)
    at_m = (0.012 * towards[0], 0.0, 0.012 * towards[2])
    return Area(link, 1, towards, 15.0, at_m, ON_A_FINGERS_FRONT)


def grasping_areas() -> tuple[Area, ...]:
    """The 24 cells of the Allegro hand that grasp: tips, pads, palm."""
    fingers = [
        area
        for first, second, tip in ((1, 2, 3), (5, 6, 7), (9, 10, 11))
        for area in (
            _on_tip(f"link_{tip}.0_tip", 30.0),
            _on_front(f"link_{second}.0", 1, 0.019),
            _on_front(f"link_{first}.0", 2, 0.014),
        )
    ]
    thumb = [_on_tip("link_15.0_tip", 60.0), _on_front("link_15.0", 1, 0.010), _on_front("link_14.0", 1, 0.022)]
    palm = Area("palm_link", 9, PALMAR, 15.0, (0.012, 0.0, -0.048), ON_A_FINGERS_FRONT)
    return (*fingers, *thumb, palm)


ON_A_WRIST = Rules(clearance=0.001, least_foam=0.0009, most_overhang=0.85, least_patch=1)


def embracing_areas(chest: int, upper_arm: int, elbow: int, forearm: int, wrist: int) -> tuple[Area, ...]:
    """Where Talos meets what it takes in both arms: so many cells of the chest and of the inside of each arm.

    An arm's directions are those in which its links look at the axis of what both arms close around.
    """
    arms = []
    for side, outward in (("left", 1.0), ("right", -1.0)):
        inside = (
            Area(f"arm_{side}_2_link", upper_arm, (1.0, 0.0, 0.0), 60.0),
            Area(f"arm_{side}_4_link", elbow, (0.1, -0.88 * outward, -0.46), 60.0),
            Area(f"arm_{side}_5_link", forearm, (0.44, -0.89 * outward, 0.15), 60.0),
            Area(
                f"arm_{side}_7_link",
                wrist,
                (0.54, -0.7 * outward, 0.47),
                60.0,
                (0.03, -0.04 * outward, -0.02),
                ON_A_WRIST,
            ),
        )
        arms += [area for area in inside if area.cells]
    return (Area("torso_2_link", chest, (1.0, 0.0, 0.0), 30.0), *arms)


def sole_areas(cells: int) -> tuple[Area, ...]:
    """The middle of each sole of Talos."""
    return tuple(
        Area(f"leg_{side}_6_link", cells, (0.0, 0.0, -1.0), 20.0, (0.0, 0.0, -0.11)) for side in ("left", "right")
    )


TALOS_LINKS = (
    "base_link",
    "torso_1_link",
    "torso_2_link",
    "head_2_link",
    *(link.format(side=side) for side in ("left", "right") for link in TALOS_LIMB_LINKS),
)

PLANS = {
    "ur5": Plan(UR5_LINKS, 260),
    "allegro_right_hand": Plan((*HAND_LINKS, *FINGER_TIPS), 62, ON_NARROW_LINKS, {"palm_link": ON_A_PALM}, tries=16),
    "talos": Plan(TALOS_LINKS, 1260, tries=2),
    "talos_embrace": Plan(
        TALOS_LINKS,
        1260,
        areas=(*embracing_areas(120, 14, 12, 20, 6), *sole_areas(27)),
        tries=2,
        robot="talos",
    ),
    "talos_grasp": Plan((), 74, areas=embracing_areas(12, 3, 10, 18, 0), tries=2, robot="talos"),
    "allegro_grasp": Plan(
        (*HAND_LINKS, *FINGER_TIPS), 62, ON_NARROW_LINKS, {"palm_link": ON_A_PALM}, areas=grasping_areas(), tries=16
    ),
    "ur5_allegro": Plan(UR5_LINKS, 162, tries=1, worn="allegro_grasp"),
    "ur5_gripper": Plan(UR5_LINKS, 130, areas=pads(), tries=1),
    "panda_gripper": Plan(PANDA_LINKS, 130, areas=pads(), tries=1),
    "dual_arm_gripper": Plan(
        DUAL_ARM_LINKS,
        720,
        areas=(*pads("left_"), *pads("right_")),
        tries=1,
    ),
    "dual_arm": Plan(DUAL_ARM_LINKS, 700, tries=1),
}
"""By name of the robot, or of the skin where a robot has several; the numbers of cells are those of the paper's."""
