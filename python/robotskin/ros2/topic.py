# SPDX-License-Identifier: Apache-2.0
"""What a topic of ROS 2 is."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Topic:
    """A topic of ROS 2. latched: those that come late are told the last message."""

    name: str
    type_name: str
    latched: bool = False
