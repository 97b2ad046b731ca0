# SPDX-License-Identifier: Apache-2.0
"""The port of a Franka Research 3. What imports nothing of the vendor's library runs without it: extra `franka`."""

from robotskin.franka.condition import FrankaCondition
from robotskin.franka.errors import FrankaError
from robotskin.franka.franka_port import FrankaPort

__all__ = ["FrankaCondition", "FrankaError", "FrankaPort"]
