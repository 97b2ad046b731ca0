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
    for force in ((1, 2), "much", (1, 2, None)):
        with pytest.raises(SensorsError, match="force is"):
            counts_of(Reading(0.5, force))  # type: ignore[arg-type]


def test_plug_ins_come_by_name() -> None:
    assert isinstance(made_sensors("robotskin.cell_sensors:Still"), Still)
    for name, why in (("no_such_module:One", "No module"), ("robotskin.errors:InputError", "no method read")):
        with pytest.raises(SensorsError, match=why):
            made_sensors(name)


BROKEN = """
from robotskin.cell_sensors import Reading

class Raises:
    def read(self, seconds):
        return Reading(1 / 0)

class Nothing:
    def read(self, seconds):
        return 0.5

class Short:
    def read(self, seconds):
        return Reading(0.5, (1.0, 2.0))

class Unmade:
    def __init__(self):
        raise OSError("no such bus")
"""


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("Raises", "ZeroDivisionError"),
        ("Nothing", "0.5: give a robotskin.cell_sensors.Reading"),
        ("Short", "force is (1.0, 2.0): give 3"),
        ("Unmade", "OSError: no such bus"),
    ],
)
def test_a_plug_in_that_fails_is_named_in_one_line(name: str, told: str, tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "broken_sensors.py").write_text(BROKEN)
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()
    assert runner.invoke(app, ["keys", "skin.key"]).exit_code == 0
    options = ["--key", "skin.key", "--sensors", f"broken_sensors:{name}", "--make", "--seconds", "5"]
    ran = runner.invoke(app, ["cell", "line", *options])
    assert ran.exit_code == 2, ran.output
    assert "Traceback" not in ran.output
    output = " ".join(ran.output.split())
    assert f"broken_sensors:{name}" in output
    assert told in output


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
