# SPDX-License-Identifier: Apache-2.0
"""A table of joints and accelerometers over time, written from a babbling, tells what the babbling itself does."""

from pathlib import Path

import numpy as np

from robotskin import layout, robots
from robotskin.configuring.exploration import Exploration
from robotskin.configuring.kept_series import KeptSeries
from robotskin.robots.free_space import FreeSpace
from robotskin.robots.gains import GainSet
from robotskin.selfconfig.babbling.plan import plan_babbling
from robotskin.selfconfig.configure import configure
from robotskin.selfconfig.kinematics.configured_kinematics import against_nominal
from robotskin.selfconfig.readings.felt_series import FeltSeries
from robotskin.selfconfig.readings.neighbour_files import load_neighbours, save_neighbours
from robotskin.selfconfig.readings.rests_and_swings import recording_of
from robotskin.selfconfig.reconstruction.accuracy import mean_errors
from robotskin.session.worn_cells import cells_in
from robotskin_lab.bench.selfconfig_cells import figures_of, placed_against
from robotskin_lab.partial_skin import part_of

JOINTS = range(5)


def test_axes_and_places_come_from_a_table_as_from_the_babbling(tmp_path: Path, seed: int) -> None:
    robot, whole = robots.load("ur5"), layout.finished("ur5")
    worn = [
        number for number, patch in enumerate(whole.patches) if patch.link not in ("shoulder_link", "upper_arm_link")
    ]
    skin = part_of(whole, np.flatnonzero(np.isin(whole.patch, worn)))
    home = GainSet.load("ur5").home
    random = np.random.default_rng(seed)
    plan = plan_babbling(FreeSpace(robot, home=home), home, random, joints=JOINTS, postures=6, swing_postures=2)
    exploration, series = Exploration(robot, skin, seed, home), KeptSeries()
    series.begin(exploration)
    babbled = exploration.babble(plan)
    exploration.stop()
    series.series().save(tmp_path / "felt.csv")
    save_neighbours(babbled.lists, tmp_path / "plugs.csv")

    read = FeltSeries.load(tmp_path / "felt.csv", robot.joint_names)
    told = recording_of(read, robot.name, load_neighbours(tmp_path / "plugs.csv", read.keys()))
    # Servos give way a little: other joints are shaken while one swings, and its swing counts all the same.
    swung = np.bincount([one.swing.joint for one in babbled.swings], minlength=robot.joint_count)
    assert (np.bincount([one.swing.joint for one in told.swings], minlength=robot.joint_count) >= swung).all()

    found = configure(robot, told)
    assert found.kinematics is not None, found.kinematics_problem
    assert max(np.rad2deg(difference.angle_rad) for difference in against_nominal(found.kinematics, robot)) < 2.0
    cells = found.layout()
    rows = cells_in(skin, cells)
    assert len(rows) > 0.9 * len(skin)
    rotation_deg, position_mm = mean_errors(cells.link_from_cell, skin.link_from_cell[rows])
    assert rotation_deg < 2.0
    assert position_mm < 8.0

    # On a robot nothing but the stated error tells how good a place is: it is neither far too small nor far too large.
    stated = figures_of(placed_against(skin, found))
    assert stated["nees_within_95"] > 0.4  # cells of a patch err together, so a few patches decide
    assert 0.5 < stated["configure_stated_over_error_mm"] < 3
    assert 0.5 < stated["configure_stated_over_error_deg"] < 3
