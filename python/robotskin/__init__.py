# SPDX-License-Identifier: Apache-2.0
"""robotskin: a sense of touch for the whole body of any robot, from the sensor to the motor."""

__version__ = "0.1.0"
