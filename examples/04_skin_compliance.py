# SPDX-License-Identifier: Apache-2.0
"""Behaviour: hold a posture and give way to touch (joint, skin and gravity task)."""

import numpy as np

import robotskin as rs

session = rs.Session(rs.load_robot("ur5"), rs.finished_layout("ur5"), "skin_compliance", interface="position")
session.boot()
push = rs.push_and_release(session, rs.pushed_cell(session, "forearm_link"), force_n=10.0)
print(
    f"gave way by {1e3 * push.displacement_m:.0f} mm and came back to within {np.rad2deg(push.return_error_rad):.2f}°"
)
assert push.displacement_m > 0.02
assert push.return_error_rad < 0.02
session.shut_down()
