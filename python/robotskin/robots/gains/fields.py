# SPDX-License-Identifier: Apache-2.0
"""What a gain file holds: the one list of its fields, from which files are checked and written."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Field:
    """One field of a gain file.

    kind: "n" a number for each joint, "6" for each axis, "1" one number, "text" a name. note: unit and meaning, the
    comment beside it in a file that is written. least: smallest value; open: the smallest value itself is refused.
    usual: what made gains have, where the robot does not decide it; None: it does.
    """

    kind: str
    note: str = ""
    least: float | None = 0.0
    open: bool = True
    usual: float | None = None
    optional: bool = False
    """A file may leave it out; then the usual value counts."""


def _zero(kind: str, note: str = "", usual: float | None = None) -> Field:
    return Field(kind, note, open=False, usual=usual)


SECTIONS: dict[str, tuple[str, dict[str, Field]]] = {
    "posture": ("", {"home": Field("n", "rad, where the skin weights are computed", least=None)}),
    "joint": (
        "joint task; its damping is the virtual robot's friction",
        {"stiffness": Field("n", "Nm/rad"), "damping": _zero("n", "Nm s/rad", usual=0.0)},
    ),
    "virtual_robot": (
        "user-set dynamics, equal for the three interfaces",
        {
            "inertia": _zero("n", "kg m^2 added to the model's own"),
            "friction_s": Field("1", "s, viscous friction of a joint over its stiffness", usual=0.45),
        },
    ),
    "inner_loop": (
        "",
        {
            "proportional": Field("n", "1/s", usual=10.0),
            "integral": _zero("n", "1/s^2, proportional^2 / 4", usual=25.0),
            "derivative": _zero("n", usual=0.0),
            "dead_zone_rad_s": _zero("1", usual=0.002),
            "estimator_hz": Field("1", usual=20.0),
            "largest_bias_rad_s": _zero("1", usual=0.05),
        },
    ),
    "resolver": (
        "",
        {
            "period_s": Field("1", usual=0.001),
            "switch_time_s": Field("1", usual=0.25),
            "largest_lead_rad": Field("1", usual=0.2),
            "position_bias_per_s": _zero("1", usual=2.0),
            "largest_bias_rad": _zero("1", usual=0.02),
            "servo_lag_s": _zero(
                "1", "s, the position servo follows as q + lag_s dq/dt + lag_s2 d2q/dt2 = command", usual=0.01375
            ),
            "servo_lag_s2": _zero("1", "s^2", usual=6.25e-5),
            "torque_bias_per_s": Field(
                "1",
                "1/s, how fast the torque interface makes up for friction that no model knows",
                open=False,
                usual=20.0,
                optional=True,
            ),
        },
    ),
    "skin": (
        "",
        {
            "compliance_m_per_n": Field("1", "how far a cell gives way to a newton, the weights follow", usual=0.003),
            "largest_give_rad_per_n": Field("1", "bound of what a newton may move a joint", usual=0.015),
            "largest_force_weight": _zero("1", "bound where the axes leave no lever", usual=600.0),
            "largest_force_weight_by_joint": Field(
                "n", "the same of all cells that a joint moves, where it is larger", open=False, optional=True
            ),
            "largest_proximity_weight_by_joint": Field(
                "n", "the same for nearness, where it is larger than for a touch", open=False, optional=True
            ),
            "proximity_n": _zero("1", "newton: the touch as which full-scale proximity counts", usual=8.0),
            "force_silent_n": _zero("1", "sum of a cell's three sensors below which nothing acts", usual=0.35),
            "force_full_n": Field("1", usual=0.9),
            "proximity_silent": _zero("1", usual=0.02),
            "proximity_full": Field("1", usual=0.05),
            "bandwidth_hz": _zero("1", usual=20.0),
            "fade_s": Field("1", usual=0.25),
        },
    ),
    "goal": ("", {"speed_rad_s": Field("1", usual=0.5)}),
    "limits": (
        "beside those of the robot model",
        {
            "acceleration": Field("n", "rad/s^2, of commands"),
            "stop_deceleration": Field("n", "rad/s^2"),
            "torque_rate": Field("n", "Nm/s"),
            "speed_share": Field(
                "1",
                "of the velocity limits, that commands may use; the rest is for what a hand adds",
                open=False,
                optional=True,
            ),
            "self_collision_stiffness": Field(
                "1", "N/m, with which bodies that are too near each other are pushed apart", optional=True
            ),
            "self_collision_damping": Field("1", "N s/m, against their coming nearer", optional=True),
        },
    ),
    "cartesian": (
        "the frame that Cartesian tasks move, its impedance along and about x, y, z of the base",
        {
            "link": Field("text"),
            "stiffness": _zero("6", "N/m, Nm/rad; 0 leaves an axis free"),
            "damping": _zero("6", "N s/m, Nm s/rad", usual=0.0),
            "speed_m_s": Field("1", usual=0.15),
            "turn_speed_rad_s": Field("1", usual=0.6),
        },
    ),
}
"""By section: what it is for, and its fields by name, in the order of a file."""

LOCKED = "locked"
"""The section that a file may leave out: where joints are held for good, rad or m by name of the joint."""

SHARES = ("joint", "cartesian", "skin", "speed")
"""What a named gain set states, each a share of the gains above."""

USUAL_SETS: dict[str, tuple[str, tuple[float, float, float, float]]] = {
    "compliant": ("", (1.0, 1.0, 1.0, 1.0)),
    "reaching": ("yields while it moves, and moves slowly", (1.0, 1.0, 1.0, 0.6)),
    "teaching": ("nothing holds the robot but its friction", (0.0, 0.0, 1.0, 1.0)),
}
"""Of made gains: what a set is for, and its shares."""

USUAL_BEHAVIOURS = {
    "skin_compliance": "compliant",
    "reach_joint_goal_compliant": "reaching",
    "reach_cartesian_compliant": "reaching",
    "reach_cartesian_goal_compliant": "reaching",
    "kinesthetic_joint": "teaching",
    "kinesthetic_cartesian": "teaching",
}
"""Of made gains: the set of each behaviour."""

KINDS = {
    "n": "a list with a number for each joint",
    "6": "a list with a number for each of six axes",
    "1": "one number",
    "text": "a name",
}
