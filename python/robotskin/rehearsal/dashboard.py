# SPDX-License-Identifier: Apache-2.0
"""What a UR controller answers at its dashboard port, a line to a line."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from robotskin.rehearsal.ur_controller import FakeController

LETTERS = {"normal": "NORMAL", "protective_stop": "PROTECTIVE_STOP", "safeguard_stop": "SAFEGUARD_STOP"}


def answer(controller: FakeController, line: str) -> str:
    """The answer to a line; the controller does what it says."""
    e_series = controller.settings.version[0] >= 5
    version = ".".join(str(part) for part in controller.settings.version)
    said = {
        "get robot model": controller.settings.model,
        "PolyscopeVersion": f"URSoftware {version} (Jan 01 2026)",
        "robotmode": f"Robotmode: {'RUNNING' if controller.powered else 'POWER_OFF'}",
        "safetystatus": f"Safetystatus: {LETTERS.get(controller.safety, 'FAULT')}",
        "safetymode": f"Safetymode: {LETTERS.get(controller.safety, 'FAULT')}",
        "running": f"Program running: {str(controller.runtime_state == 2).lower()}",
        "programState": "PLAYING" if controller.runtime_state == 2 else "STOPPED",
        "quit": "Disconnected",
    }
    if e_series and line == "is in remote control":
        return str(controller.settings.remote_control).lower()
    if line in said:
        return said[line]
    if line == "unlock protective stop":
        if controller.safety == "protective_stop":
            controller.trip("normal")
        return "Protective stop releasing"
    if line == "stop":
        controller.end_program()
        return "Stopped"
    if line in ("power on", "brake release", "power off"):
        controller.powered = line != "power off"
        return {"power on": "Powering on", "brake release": "Brake releasing", "power off": "Powering off"}[line]
    return f"could not understand: '{line}'"
