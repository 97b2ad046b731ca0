# SPDX-License-Identifier: Apache-2.0
"""Run under `unshare -rn`: a router here, a robot in a network namespace of its own, and the cable between them is
pulled for 2 s. Prints what was sent and heard."""

import json
import subprocess
import sys
import time
from pathlib import Path

from robotskin.fleet import Member, topics
from robotskin.fleet.link import open_link, open_router
from robotskin.fleet.streams import Heard, Stream
from robotskin.fleet.watch import FleetWatch

ROUTER, ROBOT = "10.77.0.1", "10.77.0.2"
CUT_S, PATIENCE_S = 2.0, 120.0
MESSAGES = 250


def ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True)


def robot(folder: Path) -> None:
    ends = time.monotonic() + PATIENCE_S
    while subprocess.run(["ip", "link", "show", "robot0"], capture_output=True).returncode:
        assert time.monotonic() < ends
        time.sleep(0.02)
    ip("addr", "add", f"{ROBOT}/24", "dev", "robot0")
    ip("link", "set", "robot0", "up")
    link = open_link(Member.load(folder / "left.fleet"), PATIENCE_S)
    stream = Stream(link, topics.of_robot("left", topics.EVENTS), run=1)
    token = link.liveliness().declare_token(topics.of_robot("left", topics.ALIVE))
    sys.stdin.readline()  # until it is listened to
    for number in range(MESSAGES):
        stream.put(str(number).encode())
        time.sleep(0.02)
    sys.stdin.read()  # until all was heard
    token.undeclare()
    link.close()


def bench(folder: Path) -> None:
    ip("link", "set", "lo", "up")
    child = subprocess.Popen(["unshare", "-n", sys.executable, __file__, "robot", str(folder)], stdin=subprocess.PIPE)
    assert child.stdin is not None
    ends = time.monotonic() + PATIENCE_S
    while Path(f"/proc/{child.pid}/ns/net").readlink() == Path("/proc/self/ns/net").readlink():
        assert time.monotonic() < ends
        time.sleep(0.02)
    ip("link", "add", "fleet0", "type", "veth", "peer", "name", "robot0", "netns", str(child.pid))
    ip("addr", "add", f"{ROUTER}/24", "dev", "fleet0")
    ip("link", "set", "fleet0", "up")
    heard: list[int] = []
    with open_router(Member.load(folder / "router.fleet")), FleetWatch(Member.load(folder / "desk.fleet")) as watch:
        link = open_link(Member.load(folder / "screen.fleet"))
        listener = Heard(link, topics.of_robot("left", topics.EVENTS), lambda _, payload: heard.append(int(payload)))

        def lives() -> bool:
            return "left" in watch.robots() and watch.robots()["left"].alive

        def until(state: bool) -> None:
            while lives() is not state:
                assert time.monotonic() < ends
                time.sleep(0.01)

        until(True)
        child.stdin.write(b"go\n")
        child.stdin.flush()
        while not heard:
            assert time.monotonic() < ends
            time.sleep(0.01)
        ip("link", "set", "fleet0", "down")
        began = time.monotonic()
        until(False)
        dead_s = watch.robots()["left"].since_s - began
        time.sleep(max(CUT_S - (time.monotonic() - began), 0.0))
        ip("link", "set", "fleet0", "up")
        until(True)
        while (not heard or heard[-1] < MESSAGES - 1) and time.monotonic() < ends:
            time.sleep(0.05)
        link.close()
    child.communicate(b"")
    # What was said before a listener came is no loss.
    in_order = heard == list(range(heard[0], MESSAGES))
    print(json.dumps({"dead_s": dead_s, "missed": listener.missed, "in_order": in_order}))


if __name__ == "__main__":
    {"robot": robot, "bench": bench}[sys.argv[1]](Path(sys.argv[2]))
