# SPDX-License-Identifier: Apache-2.0
"""What each member may do, as the router enforces it: all that is not granted here is dropped.

`ingress` is what a member sends, `egress` what it is sent. To hear, a member must be allowed to ask and to be answered.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from robotskin.fleet import topics
from robotskin.fleet.member import Listed, Role

SAID = ["put", "delete", "reply", "liveliness_token", "declare_queryable"]
ASKED = ["declare_subscriber", "query", "declare_liveliness_subscriber", "liveliness_query"]


def access_control(members: Sequence[Listed]) -> dict[str, Any]:
    """The `access_control` of the router's configuration. Every subject is named by its certificate."""
    everywhere = topics.under("*")
    rules = [
        _rule("ask", "ingress", ASKED, everywhere),
        _rule("hear", "egress", SAID, everywhere),
        # Monitors ask all robots at once, in words that no single robot's own keys take in.
        _rule("be asked", "egress", ASKED, everywhere),
        _rule("stop", "ingress", ["put"], [topics.stop_of("*")]),
        _rule("see robots that obey", "egress", ["declare_subscriber"], [topics.stop_of("*")]),
    ]
    subjects: list[dict[str, Any]] = []
    policies: list[dict[str, Any]] = []
    for one in members:
        subjects.append({"id": one.common_name, "cert_common_names": [one.common_name]})
        granted = ["ask", "hear"]
        if one.role == Role.monitor.name:
            granted += ["stop", "see robots that obey"]
        if one.role == Role.robot.name:
            own, stop = topics.under(one.name), [topics.stop_of(one.name)]
            granted = [f"{one.name} {what}" for what in ("says", "listens", "is stopped")]
            rules += [
                _rule(granted[0], "ingress", SAID, own),
                _rule(granted[1], "ingress", ["declare_subscriber"], stop),
                _rule(granted[2], "egress", ["put"], stop),
            ]
            granted.append("be asked")
        policies.append({"rules": granted, "subjects": [one.common_name]})
    return {
        "enabled": True, "default_permission": "deny", "rules": rules, "subjects": subjects, "policies": policies,
    }  # fmt: skip


def _rule(name: str, flow: str, messages: list[str], key_exprs: list[str]) -> dict[str, Any]:
    return {"id": name, "permission": "allow", "flows": [flow], "messages": messages, "key_exprs": key_exprs}
