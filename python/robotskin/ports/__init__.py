# SPDX-License-Identifier: Apache-2.0
"""What every robot port keeps to, how one is named on the command line, and one around another.

In: a `RobotPort`, simulated, real or a user's own. Out: a finding for each law of `docs/robot_port.md`.
"""

from robotskin.ports.check import Finding, Verdict, check
from robotskin.ports.clock import Clock, HostClock
from robotskin.ports.laws import LAWS
from robotskin.ports.named import PortError, made_port
from robotskin.ports.wrapped_port import WrappedPort

__all__ = ["LAWS", "Clock", "Finding", "HostClock", "PortError", "Verdict", "WrappedPort", "check", "made_port"]
