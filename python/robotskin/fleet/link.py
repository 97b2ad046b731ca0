# SPDX-License-Identifier: Apache-2.0
"""A member's session of Zenoh: TLS alone, both sides by certificate, no scouting, no listening but the router's."""

from __future__ import annotations

import base64
import json
from typing import Any

import zenoh

from robotskin.fleet.errors import FleetError
from robotskin.fleet.member import Member, Role
from robotskin.fleet.router_address import endpoint
from robotskin.fleet.rules import access_control

LEASE_MS = 700
"""A link on which nothing came for this long is dead: a robot that is lost is told within a second."""
RETRY_MS = 100
MESSAGE_BYTES_MAX = 32 << 20
PATIENCE_S = 3.0


def open_link(member: Member, patience_s: float = PATIENCE_S) -> zenoh.Session:
    """Connect a member to its router; from then on a broken link is connected again by itself.

    Raises FleetError where the router is not reached in time, or knows the member's certificate for none of its own.
    """
    zenoh.init_log_from_env_or("off")
    tls = _tls(member) | {"connect_certificate_base64": _encoded(member.certificate),
                          "connect_private_key_base64": _encoded(member.key)}  # fmt: skip
    config = _common(tls) | {
        "mode": "client",
        "connect": {
            "endpoints": [endpoint(member.router)],
            "timeout_ms": round(1e3 * patience_s),
            "exit_on_failure": True,
            "retry": {"period_init_ms": RETRY_MS, "period_max_ms": RETRY_MS, "period_increase_factor": 1.0},
        },
        "listen": {"endpoints": []},
    }
    try:
        return zenoh.open(zenoh.Config.from_json5(json.dumps(config)))
    except zenoh.ZError:
        raise FleetError(
            f"fleet: no router at {member.router} lets {member.role} {member.name} in within {patience_s:g} s: "
            "run 'robotskin fleet router' there, with the keys of the same folder"
        ) from None


def open_router(member: Member, listen: str | None = None) -> zenoh.Session:
    """The router of a fleet, where its file says or on another address of this machine, until it is closed.

    Raises FleetError: the address is taken, or not of this machine.
    """
    zenoh.init_log_from_env_or("off")
    address = listen or member.router
    tls = _tls(member) | {"listen_certificate_base64": _encoded(member.certificate),
                          "listen_private_key_base64": _encoded(member.key)}  # fmt: skip
    config = _common(tls) | {
        "mode": Role.router.name,
        "listen": {"endpoints": [endpoint(address)], "exit_on_failure": True},
        "connect": {"endpoints": []},
        "access_control": access_control(member.members),
    }
    try:
        return zenoh.open(zenoh.Config.from_json5(json.dumps(config)))
    except zenoh.ZError:
        raise FleetError(f"fleet router: cannot listen on {address}: it is taken, or not of this machine") from None


def _common(tls: dict[str, Any]) -> dict[str, Any]:
    link = {
        "protocols": ["tls"],
        "tls": tls,
        "tx": {"lease": LEASE_MS, "keep_alive": 4},
        "rx": {"max_message_size": MESSAGE_BYTES_MAX},
    }
    return {
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "adminspace": {"enabled": False},
        "transport": {"link": link, "shared_memory": {"enabled": False}},
    }


def _tls(member: Member) -> dict[str, Any]:
    return {
        "root_ca_certificate_base64": _encoded(member.authority),
        "enable_mtls": True,
        "verify_name_on_connect": True,
        "close_link_on_expiration": True,
    }


def _encoded(text: str) -> str:
    return base64.b64encode(text.encode()).decode()
