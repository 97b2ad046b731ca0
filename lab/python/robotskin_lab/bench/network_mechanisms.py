# SPDX-License-Identifier: Apache-2.0
"""What each mechanism of load balancing buys: how skins settle with it, and without it."""

from __future__ import annotations

import json
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Annotated, Any

import typer

from robotskin.keys import SkinKeys
from robotskin.layout.cell_network import CellNetwork
from robotskin_lab.bench.network_runs import PartLoads, part_loads
from robotskin_lab.bench.network_set import COMPACT, skins
from robotskin_lab.bench.progress import tell
from robotskin_lab.campaign.mutants import build, run_program, source_tree

KEPT = "docs/balance_mechanisms.json"
"""In the source tree: what was measured, those mechanisms included that are no more."""

MECHANISMS = {
    "balance": "all of it: without, cells keep their shortest ways",
    "depth_raise": "the cap on the depth rises where nothing else helps",
    "last_resort": "where no cell offers itself, cells at the border let go of what hangs on them",
    "detour": "what they let go takes farther parents too",
    "turns": "in most of these rounds, one in eight of them at a time",
}

Job = tuple[str, int, int]

FAMILIES: dict[str, list[Job]] = {
    "compact_3": [(kind, 3, seed) for kind in COMPACT for seed in range(100)],
    "compact_4_5": [(kind, ports, seed) for kind in COMPACT for ports in (4, 5) for seed in range(100)],
    "ring_12": [("ring_12", 3, seed) for seed in range(100)],
    "robot_1260": [("robot_1260", 3, seed) for seed in range(0, 100, 5)],
    "robots": [("ur5", ports, seed) for ports in (3, 5) for seed in range(0, 100, 10)]
    + [("allegro_right_hand", 3, seed) for seed in range(0, 100, 20)],
}
"""Kind, cables and seed of skins of the set."""


@dataclass(frozen=True)
class Loads:
    """How a skin settled in one of the programs. seconds: of virtual time; depth: hops of the deepest cell."""

    seconds: float
    depth: int
    parts: tuple[PartLoads, ...]

    def over(self, other: Loads) -> float:
        """Cells on the fullest cable over those of another run, the mean of the parts with more than a cell a cable."""
        pairs = zip(self.parts, other.parts, strict=True)
        return fmean([mine.fullest / theirs.fullest for mine, theirs in pairs if mine.ideal > 1] or [1.0])

    @property
    def worst(self) -> float:
        """Cells on the fullest cable over an even share, of the part where that is most."""
        return max(part.fullest / part.ideal for part in self.parts)


def case_text(network: CellNetwork, seed: int) -> str:
    """A skin as the programs of the campaign read it, without faults, of cells that compute in no time."""

    def end(cell: int, port: int) -> str:
        return f"{cell}.{port}" if cell >= 0 else "-"

    lines = [f"seed {seed + 1}", f"key {SkinKeys.of_seed(seed).cell_key.hex()}"]
    units: dict[tuple[int, int], dict[int, str]] = {}
    for cable in network.cables:
        units.setdefault((cable.group, cable.unit), {})[cable.port] = end(cable.cell, cable.cell_port)
    for (group, unit), ports in sorted(units.items()):
        lines.append(f"unit {group} {unit} " + " ".join(ports.get(port, "-") for port in range(1, max(ports) + 1)))
    for own, identity in zip(network.neighbours, network.id, strict=True):
        lines.append("cell " + " ".join(end(int(cell), int(port)) for cell, port in own) + f" {identity}")
    return "\n".join(lines) + "\n"


def settle_in(folder: Path, program: str, kind: str, ports: int, seed: int) -> Loads:
    """How a skin of the set settles with the firmware of the program `campaign_PROGRAM`."""
    network = skins(kind, ports, seed)
    even = -(-len(network) // len(network.cables)) if int(network.part.max()) == 0 else 0
    (found,) = run_program(folder, program, "settle", even, text=case_text(network, seed))
    units = sorted({(cable.group, cable.unit) for cable in network.cables})
    loads = [found["loads"][units.index((c.group, c.unit))][c.port - 1] for c in network.cables]
    return Loads(found["seconds"], found["depth"], part_loads(network, loads))


def bought(shipping: Iterable[Loads], without: Iterable[Loads]) -> dict[str, float]:
    """What a mechanism buys on some skins: per cent of the fullest cable's load in the mean, and what else it changes.

    worst: of the skins, over an even share, without it. better, worse: share of the skins that are so with it.
    seconds, hops: by how much longer balance takes, and deeper the deepest cell is, without it.
    """
    pairs = list(zip(shipping, without, strict=True))
    over = [left_out.over(kept) for kept, left_out in pairs]
    return {
        "percent": 100 * (fmean(over) - 1),
        "worst": max(left_out.worst for _, left_out in pairs),
        "better": fmean(one > 1 for one in over),
        "worse": fmean(one < 1 for one in over),
        "seconds": fmean(left_out.seconds - kept.seconds for kept, left_out in pairs),
        "hops": fmean(left_out.depth - kept.depth for kept, left_out in pairs),
    }


def run(
    *,
    seed: int = 1,
    mechanisms: Annotated[
        str, typer.Option(help="With commas between them; all by default.", show_default=False)
    ] = ",".join(MECHANISMS),
    step: Annotated[int, typer.Option(help="Every how many of the skins; 1 is all.", min=1)] = 1,
    write: Annotated[bool, typer.Option(help=f"Keep the result in {KEPT}.")] = False,
) -> dict[str, Any]:
    """Settle skins of the fixed set with the shipping firmware, and with firmware that lacks one mechanism of balance.

    The skins are the same for every seed.
    """
    del seed
    wanted = mechanisms.split(",")
    unknown = [name for name in wanted if name not in MECHANISMS]
    if unknown:
        raise typer.BadParameter(f"{unknown[0]!r}: the mechanisms are {', '.join(MECHANISMS)}")
    programs = ["shipping", *(f"without_{name}" for name in wanted)]
    folder = build(*programs)
    jobs = {family: listed[::step] for family, listed in FAMILIES.items()}
    settled: dict[str, dict[str, list[Loads]]] = {}
    with ThreadPoolExecutor(2) as pool:
        for program in programs:
            tell(f"bench network_mechanisms: {program}")
            settled[program] = {
                family: list(pool.map(lambda job, program=program: settle_in(folder, program, *job), listed))
                for family, listed in jobs.items()
            }
    shipping = settled["shipping"]
    result = {
        name: {family: bought(shipping[family], settled[f"without_{name}"][family]) for family in jobs}
        for name in wanted
    }
    if write:
        keep(result, shipping)
    figures: dict[str, Any] = {f"worst_{family}": max(one.worst for one in shipping[family]) for family in jobs}
    figures |= {f"skins_{family}": len(listed) for family, listed in jobs.items()}
    for name, by_family in result.items():
        figures |= {f"{name}_buys_percent_{family}": one["percent"] for family, one in by_family.items()}
    return figures


def keep(result: dict[str, dict[str, dict[str, float]]], shipping: dict[str, list[Loads]]) -> None:
    """Write what was measured into the kept file; what is there of other mechanisms stays."""
    file = source_tree() / KEPT
    kept = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {"mechanisms": {}}
    kept["skins"] = {family: len(runs) for family, runs in shipping.items()}
    kept["worst"] = {family: round(max(one.worst for one in runs), 3) for family, runs in shipping.items()}
    for name, by_family in result.items():
        verdict = kept["mechanisms"].get(name, {}).get("verdict", "stays")
        kept["mechanisms"][name] = {"text": MECHANISMS[name], "verdict": verdict} | {
            family: {key: round(value, 3) for key, value in one.items()} for family, one in by_family.items()
        }
    file.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
