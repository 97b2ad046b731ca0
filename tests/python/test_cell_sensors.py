# SPDX-License-Identifier: Apache-2.0
"""Sensors of a host-built cell as a plug-in: what they read becomes counts, and what no cell can send is refused."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from robotskin import firmware
from robotskin.cell_sensors import Reading, SensorsError, Still, counts_of, made_sensors
from robotskin.cli.main import app

INCLUDE = Path(__file__).parents[2] / "firmware" / "include"


def test_readings_become_counts_of_their_channels(seed: int) -> None:
    random = np.random.default_rng(seed)
    force, acceleration = random.uniform(0, 9.9, 3), random.uniform(-1.9, 1.9, 3)
    reading = Reading(random.uniform(0, 0.99), tuple(force), tuple(acceleration), (24.5, 31.25))
    counts, fault = counts_of(reading)
    steps = np.array([step for _, _, _, step, _ in firmware.CHANNELS])
    values = np.concatenate([[reading.proximity], force, acceleration, [24.5, 31.25]])
    assert not fault
    assert (np.abs(counts[0] * steps - values) <= steps / 2 + 1e-12).all()


def test_what_is_missing_or_at_its_end_is_a_fault() -> None:
    assert counts_of(Reading(0.5))[1]
    assert counts_of(Reading(0.5, (30, 0, 0), (0, 0, 1), (20, 20)))[1]
    with pytest.raises(SensorsError, match="force is"):
        counts_of(Reading(0.5, (1, 2)))  # type: ignore[arg-type]


def test_plug_ins_come_by_name() -> None:
    assert isinstance(made_sensors("robotskin.cell_sensors:Still"), Still)
    for name, why in (("no_such_module:One", "No module"), ("robotskin.errors:InputError", "no method read")):
        with pytest.raises(SensorsError, match=why):
            made_sensors(name)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc)")
def test_a_cell_runs_with_sensors_in_python_or_c(tmp_path: Path) -> None:
    source, library = tmp_path / "sense.c", tmp_path / "sense.so"
    source.write_text(
        '#include <stdbool.h>\n#include "robotskin/channels.h"\nbool rs_board_sense(rs_sample* sample);\n'
        "bool rs_board_sense(rs_sample* sample) { *sample = (rs_sample){{7}}; return false; }\n"
    )
    subprocess.run(["cc", "-shared", "-fPIC", f"-I{INCLUDE}", str(source), "-o", str(library)], check=True)
    runner = CliRunner()
    key, line = tmp_path / "skin.key", tmp_path / "line"
    assert runner.invoke(app, ["keys", str(key)]).exit_code == 0
    for sensors in (str(library), "robotskin.cell_sensors:Still"):
        options = ["--key", str(key), "--sensors", sensors, "--make", "--seconds", "0.3"]
        ran = runner.invoke(app, ["cell", str(line), *options])
        assert ran.exit_code == 0, ran.output
        assert "samples" in ran.output
    refused = runner.invoke(app, ["unit", str(tmp_path / "nothing"), "--key", str(key)])
    assert refused.exit_code == 2
    assert "No such file" in refused.output
