"""Which links of well-known robots are covered, with how many cells and under which rules."""

from dataclasses import dataclass, field

from robotskin.layout.places import Rules

UR5_LINKS = ("shoulder_link", "upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link")
FINGERS = tuple(f"link_{number}.0" for number in range(16))


@dataclass(frozen=True)
class Plan:
    """links: names; cells: in all; rules: of places; description: for the command line."""

    links: tuple[str, ...]
    cells: int
    rules: Rules = field(default_factory=Rules)


PLANS = {
    "ur5": Plan(UR5_LINKS, 260),
    "dual_arm": Plan((*(f"{side}_{link}" for side in ("left", "right") for link in UR5_LINKS), "torso"), 700),
}
"""By robot name; the numbers of cells are those of the paper's robots."""
