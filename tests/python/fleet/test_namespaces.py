# SPDX-License-Identifier: Apache-2.0
"""A robot in a network namespace of its own: the cable is pulled, and nothing is lost."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("zenoh")

from robotskin.fleet.authority import make_keys

IN_THEM = Path(__file__).with_name("in_namespaces.py")


def refused() -> str:
    """Why namespaces cannot be had here; empty where they can."""
    for tool in ("unshare", "ip"):
        if shutil.which(tool) is None:
            return f"no {tool} on this machine"
    made = "ip link add fleet0 type veth peer name robot0 && unshare -n true"
    done = subprocess.run(["unshare", "-rn", "sh", "-c", made], capture_output=True, text=True)
    return f"network namespaces are not allowed here: {done.stderr.strip()}" if done.returncode else ""


@pytest.mark.real_time
def test_the_cable_of_a_robot_is_pulled(tmp_path: Path) -> None:
    if reason := refused():
        pytest.skip(reason)
    make_keys(tmp_path, ["left"], ["desk"], ["screen"], "10.77.0.1:7447")
    done = subprocess.run(
        ["unshare", "-rn", sys.executable, str(IN_THEM), "bench", str(tmp_path)],
        capture_output=True, text=True, timeout=250,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["in_order"]
    assert told["missed"] == 0
    assert 0.0 < told["dead_s"] < 180.0
