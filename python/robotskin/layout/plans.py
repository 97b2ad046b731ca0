"""Which links of well-known robots are covered, with how many cells and under which rules."""

from dataclasses import dataclass, field

from robotskin.layout.places import Rules

UR5_LINKS = ("shoulder_link", "upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link")
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
    """links: names; cells: in all; rules: of places, other ones for some links; tries: first cells of each patch."""

    links: tuple[str, ...]
    cells: int
    rules: Rules = field(default_factory=Rules)
    link_rules: dict[str, Rules] = field(default_factory=dict)
    tries: int = 3


PLANS = {
    "ur5": Plan(UR5_LINKS, 260),
    "allegro_right_hand": Plan((*HAND_LINKS, *FINGER_TIPS), 62, ON_NARROW_LINKS, {"palm_link": ON_A_PALM}, tries=16),
    "talos": Plan(
        (
            "base_link",
            "torso_1_link",
            "torso_2_link",
            "head_2_link",
            *(link.format(side=side) for side in ("left", "right") for link in TALOS_LIMB_LINKS),
        ),
        1260,
        tries=2,
    ),
    "dual_arm": Plan(tuple(f"{side}_{link}" for side in ("left", "right") for link in UR5_LINKS), 700, tries=1),
}
"""By robot name; the numbers of cells are those of the paper's robots."""
