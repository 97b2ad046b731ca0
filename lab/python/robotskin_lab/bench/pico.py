# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench pico`: the firmware on an emulated Raspberry Pi Pico, in a small skin and as the busiest of 66."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from robotskin.firmware import CELLS_PER_PORT
from robotskin_lab import firmware
from robotskin_lab.bench.progress import tell
from robotskin_lab.chip.emulated_pico import HZ, EmulatedPico
from robotskin_lab.chip.pico_image import build_pico, cell_keys
from robotskin_lab.chip.pico_replay import RECORDING, replay
from robotskin_lab.chip.pico_skin import UID, PicoSkin

PERIOD_MS = 4.0
SETTLE_MS = 30.0
FORM_MS = 400.0
FRAME_US = 50.0


def run(
    *, seed: int = 1, cells: int = CELLS_PER_PORT, milliseconds: float = 200.0, samples: int = 1000
) -> dict[str, float]:
    """Size, samples lost, processor, gaps on a busy line, and a replay by the host-built program.

    Args:
        seed: of the key, and of what the Pico draws.
        cells: of the skin whose busiest is the Pico.
        milliseconds: for which that skin is counted.
        samples: of the Pico in the record that is replayed.
    """
    random = np.random.default_rng(seed)
    key = random.bytes(firmware.CELL_KEY_BYTES)
    keys = cell_keys(key, UID)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        image = build_pico()
        (folder / "cell.uf2").write_bytes(image.uf2(UID, keys))
        figures = {"pico_flash_bytes": float(len(image.flash)), "pico_ram_bytes": float(image.ram_bytes)}
        tell(f"busiest of {cells}")
        figures |= busiest(folder / "cell.uf2", key, seed, cells, milliseconds)
        tell("replay")
        (folder / "recording.uf2").write_bytes(build_pico(options=[RECORDING]).uf2(UID, keys))
        record = folder / "record.txt"
        pico = EmulatedPico(folder / "recording.uf2", seed, record)
        try:
            skin = PicoSkin(pico, 3, key)
            skin.run_until(lambda: skin.named == 4, FORM_MS)
            figures["pico_named_ms"] = skin.now / 1000
            skin.run(samples * PERIOD_MS + SETTLE_MS)
        finally:
            pico.close()
        compared = replay(record, folder, UID, keys)
        figures["pico_replayed_samples"] = float(compared["samples"])
        identical = compared["differences"] == 0 and compared["samples"] >= samples
        return figures | {"pico_identical_frames": float(identical), "pico_replayed_frames": float(compared["sent"])}


def busiest(uf2: Path, key: bytes, seed: int, cells: int, milliseconds: float) -> dict[str, float]:
    """The Pico between the section unit and three chains of host-built cells."""
    pico = EmulatedPico(uf2, seed)
    try:
        skin = PicoSkin(pico, cells - 1, key)
        named = skin.run_until(lambda: skin.named == cells, FORM_MS)
        skin.run(SETTLE_MS)
        skin.samples.clear()
        skin.ends.clear()
        began_us, busy, missing = skin.now, pico.told["busy_cycles"], skin.driver.statistics()["frames_missing"]
        skin.run(milliseconds)
        gone_us = skin.now - began_us
        short = round(gone_us / 1000 / PERIOD_MS) * cells - len(skin.samples)
        missing = skin.driver.statistics()["frames_missing"] - missing
        gaps = np.diff([ended for _, ended in skin.ends]) - FRAME_US
        return {
            "pico_all_named_66": float(named),
            "pico_samples_66": float(len(skin.samples)),
            "pico_samples_lost_66": float(max(0, short, missing)),
            "pico_busy_percent": 100 * (pico.told["busy_cycles"] - busy) / (gone_us * HZ / 1e6),
            "pico_line_gap_us": float(np.median(gaps)),
            "pico_framing_errors": float(pico.told["framing_errors"]),
            "pico_complaints": float(len(pico.told["said"])),
        }
    finally:
        pico.close()
