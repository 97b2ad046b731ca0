# SPDX-License-Identifier: Apache-2.0
"""What the force sensors of each cell really felt: gain, offset and crosstalk, from known forces or from joint torques.

In: presses of cells, by a probe of known force or against a fixed post with the robot's joint torques as the reference.
Out: a `Calibration` with a covariance, a file that is refused for another skin, and its drift while the robot works.
"""

from robotskin.calibration.calibration import Calibration
from robotskin.calibration.drift import ZeroWatch
from robotskin.calibration.errors import CalibrationError
from robotskin.calibration.estimate import Known, calibrate
from robotskin.calibration.presses import Presses

__all__ = ["Calibration", "CalibrationError", "Known", "Presses", "ZeroWatch", "calibrate"]
