# SPDX-License-Identifier: Apache-2.0
"""Skins of several robots, seen and stopped from one place, over Zenoh with mutual TLS."""

from robotskin.fleet.errors import FleetError
from robotskin.fleet.member import Member, Role

__all__ = ["FleetError", "Member", "Role"]
