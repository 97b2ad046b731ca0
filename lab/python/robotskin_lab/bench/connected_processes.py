# SPDX-License-Identifier: Apache-2.0
"""`robotskin unit`, `robotskin connect` and a looker at its page in processes of their own, which may be killed."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import re
import socket
import sys
import time
import tty
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import msgspec
import numpy as np
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

from robotskin.cli.main import app
from robotskin.keys import SkinKeys
from robotskin.layout import finished
from robotskin.rehearsal import Asked, Look, Process, RehearsalError, serial_skin
from robotskin_lab.bench.connect_rig import patch_of
from robotskin_lab.bench.watched_controller import watched_controller

ROBOT, LINK = "ur5", "forearm_link"
UNIT_PORT = 21100
START_S, TRIES = 60.0, 5
AGAIN_S = 1.0
"""Between two tries of a page to reach its server."""
EYE = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (2.0, 0.0, 1.0),
    "fov": 1.0,
    "near": 0.01,
    "far": 100.0,
    "image_height": 100,
    "image_width": 100,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}
"""What a browser tells of its camera: only then it counts as one that looks."""


class Looker:
    """Looks at a page as a browser does, also when it is served anew, but draws nothing."""

    _socket: ClientConnection

    def __init__(self, address: str) -> None:
        self.open(address)

    def _look(self) -> ClientConnection:
        spoken = Subprotocol(f"viser-v{version('viser')}")
        looking = connect(self._address, subprotocols=[spoken], max_size=None)
        looking.send(msgspec.msgpack.encode(EYE))
        return looking

    def run(self, seconds: float) -> None:
        """Take what the page sends."""
        ends = time.monotonic() + seconds
        try:
            while (left := ends - time.monotonic()) > 0:
                self._socket.recv(timeout=left)
        except TimeoutError:
            pass
        except ConnectionClosed:
            time.sleep(AGAIN_S)
            with contextlib.suppress(OSError, InvalidStatus):
                self._socket = self._look()

    def open(self, address: str) -> None:
        """Open an address: a session that was started again prints one with a token of its own."""
        self._address = address.replace("http:", "ws:")
        self._socket = self._look()

    def close(self) -> None:
        """Look away."""
        self._socket.close()


PRELOADED = [
    "robotskin.cli.connect",
    "robotskin.cli.unit",
    "robotskin.connecting",
    "robotskin.live.connected_session",
    "robotskin.ports",
    "robotskin.serial_lines",
    "robotskin.ur",
    "robotskin.viewer.page",
    "robotskin_lab.bench.connect_faults",
    __name__,
]
"""What a server process imports once: commands forked from it start within a second."""


def _command(terminal: str, output: str, arguments: tuple[str, ...]) -> None:
    """A `robotskin` command in this process, which has a terminal for its input and a file for its output."""
    os.dup2(os.open(terminal, os.O_RDWR | os.O_NOCTTY), 0)
    sink = os.open(output, os.O_WRONLY)
    os.dup2(sink, 1)
    os.dup2(sink, 2)
    sys.stdin = os.fdopen(0, closefd=False)
    sys.stdout = sys.stderr = os.fdopen(1, "w", buffering=1, closefd=False)
    os.environ["COLUMNS"] = "300"
    os.chdir(Path(output).parent)
    app(arguments)


class Started:
    """A `robotskin` command that has told what `pattern` finds; `said` is the match's first group."""

    def __init__(self, output: Path, pattern: str, *arguments: str) -> None:
        self._terminal, theirs = os.openpty()
        tty.setraw(theirs)
        output.write_text("")
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(PRELOADED)
        self._process = context.Process(target=_command, args=(os.ttyname(theirs), str(output), arguments), daemon=True)
        self._process.start()
        ends = time.monotonic() + START_S
        try:
            while not (found := re.search(pattern, output.read_text())):
                if self.ended or time.monotonic() > ends:
                    told = output.read_text().strip() or "nothing"
                    self.kill()
                    raise RehearsalError(f"robotskin {arguments[0]} does not start; it said: {told}")
                time.sleep(0.05)
        finally:
            os.close(theirs)  # the command has opened it by now
        self.said = found.group(1)

    @property
    def ended(self) -> bool:
        """Whether it has ended."""
        return not self._process.is_alive()

    def type(self, text: str) -> None:
        """Type a line in its terminal."""
        os.write(self._terminal, text.encode() + b"\n")

    def kill(self) -> None:
        """End it in the middle of whatever it does."""
        self._process.kill()
        self._process.join()
        os.close(self._terminal)


class ConnectedProcesses:
    """A rehearsed UR5 at `host` with a serial skin, whose unit, session and page are started by name.

    Args:
        host: address of this machine for controller and unit.
        folder: for layout, keys, lines and what the processes say.
        seed: of the skin.
    """

    def __init__(self, host: str, folder: Path, seed: int) -> None:
        self._host, self._folder = host, folder
        self._layout, self._key = folder / "skin.json", folder / "skin.key"
        worn = patch_of(finished(ROBOT), LINK)
        worn.save(self._layout)
        SkinKeys.fresh().save(self._key)
        self.cells = len(worn)
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self._page_port = int(probe.getsockname()[1])
        self._held = contextlib.ExitStack()
        try:
            self.arm = self._held.enter_context(watched_controller(ROBOT, host))
            made = serial_skin(ROBOT, folder / "lines", host, layout=self._layout, key=self._key, seed=seed)
            self.skin = self._held.enter_context(made)
            self._lines = self.skin.ask(Look(("lines",)))[0]
            self.running: dict[str, Started | Process] = {}
            self._held.callback(self._kill_all)
            for name in self._makers():
                self.start(name)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> ConnectedProcesses:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _makers(self) -> dict[str, Callable[[], Started | Process]]:
        return {"unit": self._start_unit, "session": self._start_session, "page": self._start_page}

    def _start_unit(self) -> Started:
        (group, unit, _), *_ = self._lines
        at = ("--listen", f"{self._host}:{UNIT_PORT}", "--group", str(group), "--unit", str(unit))
        return self._started("unit", r"(section unit)", "unit", *self._lines.values(), "--key", str(self._key), *at)

    def _start_session(self) -> Started:
        ends = ("--robot-port", f"ur:{self._host}", "--units", f"{self._host}:{UNIT_PORT}", "--confirmed")
        worn = ("--key", str(self._key), "--layout", str(self._layout))
        page = ("--port", str(self._page_port))
        return self._started("session", r"open (http://[^ ]+)", "connect", ROBOT, *ends, *worn, *page)

    def _started(self, name: str, pattern: str, *arguments: str) -> Started:
        return Started(self._folder / f"{name}.txt", pattern, *arguments)

    def _start_page(self) -> Process:
        return Process(Looker, preloaded=__name__, address=self.session.said)

    @property
    def session(self) -> Started:
        """`robotskin connect`."""
        session = self.running["session"]
        assert isinstance(session, Started)
        return session

    def start(self, name: str) -> None:
        """Start unit, session or page. Raises RehearsalError.

        On a busy machine a session may find the robot late, and ends: it is tried again.
        """
        for left in reversed(range(TRIES)):
            try:
                self.running[name] = self._makers()[name]()
                break
            except RehearsalError:
                if left == 0:
                    raise
        page = self.running.get("page")
        if name == "session" and isinstance(page, Process):
            page.ask(Asked("open", (self.session.said,)))

    def kill(self, name: str) -> None:
        """End it in the middle of whatever it does."""
        self.running.pop(name).kill()

    def ended(self) -> list[str]:
        """Which have ended without being killed; a page that has lost its server has not."""
        return [name for name, one in self.running.items() if isinstance(one, Started) and one.ended]

    def moves(self, cell: int, force_n: float, faster_rad_s: float, within_s: float) -> bool:
        """Touch a cell, and start the robot anew where it stands still, until a joint is that fast."""
        ends = time.monotonic() + within_s
        while time.monotonic() < ends and not self.ended():
            self.skin.ask(Asked("release"))
            self.session.type("g")
            time.sleep(0.3)
            self.skin.ask(Asked("push", (cell, force_n)))
            pushed = time.monotonic()
            while time.monotonic() < pushed + 1.0:
                if np.abs(self.arm.ask(Look(("arm.velocity",)))[0]).max() > faster_rad_s:
                    return True
        return False

    def _kill_all(self) -> None:
        for name in list(self.running):
            self.kill(name)

    def close(self) -> None:
        """End all of it."""
        self._held.close()
