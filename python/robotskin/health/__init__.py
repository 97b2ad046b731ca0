# SPDX-License-Identifier: Apache-2.0
"""Health of every cell, named, while the robot works: from gravity, motion, neighbours and touch."""

from robotskin.health.kinds import Finding, Kind
from robotskin.health.watch import HealthWatch

__all__ = ["Finding", "HealthWatch", "Kind"]
