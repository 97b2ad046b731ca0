# SPDX-License-Identifier: Apache-2.0
"""A fleet: what broken links lose, how fast a dead robot shows and a stop is obeyed, and what strangers get in."""

from __future__ import annotations

import contextlib
import json
import multiprocessing
import socket
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
import typer

from robotskin.errors import RobotskinError
from robotskin_lab.bench.progress import tell

Figures = dict[str, float | int | str]
CUT_S, CUT_SHORT_S = 2.0, 1.0
SETTLE_S = 0.5
HEARD_WITHIN_S = 60.0
PER_PROCESS = 5
STOPS_A_MINUTE = 12
RECORDED_S = 12.0


def run(
    *,
    seed: Annotated[int, typer.Option(help="Of touches and of the imperfect world.", min=0)] = 1,
    robots: Annotated[int, typer.Option(help="In all.", min=2)] = 20,
    seconds: Annotated[float, typer.Option(help="Of the load.", min=1)] = 600.0,
    short: Annotated[bool, typer.Option("--short", help="Two robots and a few seconds, in this process.")] = False,
) -> Figures:
    """Twenty robots of 62 cells, one of them live, the others recorded senders, through one router on the loopback.

    Each link is broken once for 2 s, half of them so that no end is told. `fleet_dead_peer_s`: from then until the
    monitor tells it, the worst. `fleet_stop_p99_ms`: from the monitor's order until the robot has obeyed, by the clock
    that all share; `fleet_stop_told_p99_ms`: until the monitor has heard so. `stranger_frames_accepted`: of those
    without a certificate, with one of another authority, and with a right one under forbidden keys.
    """
    try:
        import zenoh  # noqa: F401
    except ImportError as error:
        raise RobotskinError("bench fleet needs eclipse-zenoh: pip install 'robotskin[fleet]'") from error
    from robotskin_lab.bench import fleet_rig

    if short:
        robots, seconds = 2, 1.0
    names = [f"robot{number}" for number in range(robots)]
    with tempfile.TemporaryDirectory() as place, contextlib.ExitStack() as stack:
        stack.callback(sys.setswitchinterval, sys.getswitchinterval())
        sys.setswitchinterval(fleet_rig.SWITCH_S)
        return _measured(Path(place), stack, names, seed, seconds, processes=not short)


def _measured(
    place: Path, stack: contextlib.ExitStack, names: list[str], seed: int, seconds: float, processes: bool
) -> Figures:
    from robotskin.fleet import Member
    from robotskin.fleet.authority import make_keys
    from robotskin.fleet.watch import FleetWatch
    from robotskin_lab.bench import fleet_rig

    folder, path = place / "keys", place / "felt.mcap"
    make_keys(folder, [*names, "guest"], ["desk"], [], f"127.0.0.1:{_free_port()}")
    tell("fleet: the recording")
    fleet_rig.record(path, seed, RECORDED_S if processes else 2.0)
    serve = _serve(stack, processes)
    serve(_router, folder)
    live, recorded = names[:1], names[1:]
    groups = [recorded[at : at + PER_PROCESS] for at in range(0, len(recorded), PER_PROCESS)]
    pipes = {tuple(live): serve(fleet_rig.serve_live, folder, live, seed)}
    pipes |= {tuple(group): serve(fleet_rig.serve_recorded, folder, group, path) for group in groups}
    member = Member.load(folder / "desk.fleet")
    watch = stack.enter_context(FleetWatch(member))
    ears = serve(fleet_rig.serve_ears, folder, names)
    until(lambda: sum(seen.alive for seen in watch.robots().values()) == len(names), "not all are in the fleet")
    time.sleep(SETTLE_S)
    for pipe in pipes.values():
        pipe.send(("go",))
        pipe.recv()
    if missing := watch.await_robots(names, HEARD_WITHIN_S):
        raise RobotskinError(f"bench fleet: silent: {', '.join(sorted(missing))}")
    began = time.monotonic()
    dead_s: list[float] = []
    stops_ms: list[tuple[float, float]] = []
    accepted = _strangers(folder, names)
    for turn, name in enumerate(names):
        tell(f"fleet: the link of {name} is broken")
        pipe = next(pipe for group, pipe in pipes.items() if name in group)
        way, cut_s = "cut" if turn % 2 else "swallow", CUT_S if processes else CUT_SHORT_S
        dead_s.append(_broken(pipe, watch, name, way, cut_s))
        stops_ms += _stopped(watch)
        ends = began + seconds * (turn + 1) / len(names)
        while (left := ends - time.monotonic()) > 0:
            time.sleep(min(left, 60.0 / STOPS_A_MINUTE))
            stops_ms += _stopped(watch)
    accepted += _strangers(folder, names)
    lasted_s = time.monotonic() - began
    tell("fleet: the last events")
    told: dict[str, tuple[int, int, int, int, list[float]]] = {}
    for pipe in pipes.values():
        pipe.send(("end",))
        told |= pipe.recv()
    ears.send(({name: told[name][0] for name in names}, HEARD_WITHIN_S))
    heard, missed, refused = ears.recv()
    for pipe in pipes.values():
        pipe.send("bye")
    tell("")
    lost = [max(told[name][0] - heard[name][0], 0) for name in names]
    differing = sum(heard[name] != told[name][:2] for name in names)
    guard_ms = [ms for name in live for ms in told[name][4]]
    return {
        "fleet_robots": len(names),
        "fleet_live": len(live),
        "fleet_seconds": round(lasted_s, 1),
        "fleet_events": sum(told[name][0] for name in names),
        "fleet_events_lost": sum(lost),
        "fleet_robots_differing": differing,
        "fleet_messages_missed": missed,
        "fleet_blocks_dropped": sum(told[name][2] for name in names),
        "fleet_dead_peer_s": max(dead_s),
        "fleet_stops": len(stops_ms),
        "fleet_stop_p50_ms": float(np.percentile(stops_ms, 50, axis=0)[0]),
        "fleet_stop_p99_ms": float(np.percentile(stops_ms, 99, axis=0)[0]),
        "fleet_stop_told_p99_ms": float(np.percentile(stops_ms, 99, axis=0)[1]),
        "fleet_stop_guard_ms": max(guard_ms, default=float("nan")),
        "stranger_frames_accepted": accepted + refused + watch.refused + sum(told[name][3] for name in names),
    }  # fmt: skip


def _broken(pipe: Connection, watch: Any, name: str, way: str, cut_s: float) -> float:
    """Seconds from breaking a link until the monitor knew; it is whole again after `cut_s`."""
    pipe.send((way, name))
    began: float = pipe.recv()
    until(lambda: not watch.robots()[name].alive, f"{name} does not show as dead")
    took_s: float = watch.robots()[name].since_s - began
    time.sleep(max(cut_s - (time.monotonic() - began), 0.0))
    pipe.send(("mend", name))
    pipe.recv()
    until(lambda: watch.robots()[name].alive, f"{name} does not come back")
    return took_s


def _stopped(watch: Any) -> list[tuple[float, float]]:
    """Milliseconds until each robot had obeyed, and until the monitor had heard so; a minute for one that never did."""
    began_ns = time.monotonic_ns()
    took = watch.stop()
    never_ms = 1e3 * HEARD_WITHIN_S
    return [
        (never_ms, never_ms)
        if took_s is None
        else ((watch.robots()[name].state.obeyed_ns - began_ns) * 1e-6, 1e3 * took_s)
        for name, took_s in took.items()
    ]


def until(true: Callable[[], bool], told: str) -> None:
    """Wait. Raises RobotskinError after a minute."""
    ends = time.monotonic() + HEARD_WITHIN_S
    while not true():
        if time.monotonic() > ends:
            raise RobotskinError(f"bench fleet: {told} within {HEARD_WITHIN_S:g} s")
        time.sleep(0.005)


def _strangers(folder: Path, names: Sequence[str]) -> int:
    """Try to get in, and to say what is forbidden; how many strangers got in. What is forged bears a mark."""
    import zenoh

    from robotskin.fleet import FleetError, Member, Role, topics
    from robotskin.fleet.authority import Authority
    from robotskin.fleet.link import open_link
    from robotskin.fleet.messages import Order, packed
    from robotskin_lab.bench.fleet_rig import FORGED

    member, got_in = Member.load(folder / f"{names[0]}.fleet"), 0
    false_one = Authority.fresh().member(member.name, Role.robot, member.router)
    for stranger in (false_one, msgspec.structs.replace(false_one, authority=member.authority)):
        with contextlib.suppress(FleetError):
            open_link(stranger, 0.5).close()
            got_in += 1
    for protocol in ("tls", "tcp"):
        router = {"endpoints": [f"{protocol}/{member.router}"], "timeout_ms": 500, "exit_on_failure": True}
        config = {"mode": "client", "scouting": {"multicast": {"enabled": False}}, "connect": router}
        with contextlib.suppress(zenoh.ZError):
            zenoh.open(zenoh.Config.from_json5(json.dumps(config))).close()
            got_in += 1
    with open_link(Member.load(folder / "guest.fleet"), HEARD_WITHIN_S) as guest:
        for name in names:
            for what in (topics.STATE, topics.TAPE, topics.EVENTS, topics.ABOUT):
                guest.put(topics.of_robot(name, what), FORGED.encode())
            guest.put(topics.stop_of(name), packed(Order(1, FORGED)))
        time.sleep(0.2)
    return got_in


def _router(pipe: Connection, folder: Path) -> None:
    from robotskin.fleet import Member
    from robotskin.fleet.link import open_router

    with open_router(Member.load(folder / "router.fleet")):
        pipe.send("ready")
        with contextlib.suppress(EOFError):
            pipe.recv()


def _served(server: Callable[..., None], pipe: Connection, *arguments: Any) -> None:
    """Serve until the bench is no more: what the bench says of its own end is not buried under that of its servers."""
    with contextlib.suppress(EOFError):
        server(pipe, *arguments)


def _serve(stack: contextlib.ExitStack, processes: bool) -> Callable[..., Connection]:
    """What runs a server beside the bench, in a process or a thread of its own, and gives the pipe to it when ready."""
    context = multiprocessing.get_context("spawn")

    def serve(server: Callable[..., None], *arguments: Any) -> Connection:
        ours, theirs = context.Pipe()
        make: Any = context.Process if processes else threading.Thread
        made = make(target=_served, args=(server, theirs, *arguments), daemon=True)
        made.start()
        stack.callback(made.join, 10.0)
        stack.callback(ours.close)
        tell(f"fleet: {server.__name__}")
        ours.recv()
        return ours

    return serve


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return int(listener.getsockname()[1])
