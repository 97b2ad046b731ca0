# SPDX-License-Identifier: Apache-2.0
"""A file of limits by body region: empty as it comes, and every mistake in it is refused by file, region and field."""

from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from robotskin.control.body_limits import EMPTY_FILE, FIELDS, BodyLimits, BodyLimitsError
from robotskin.errors import UnknownNameError
from robotskin.layout import finished

SOURCE = 'source = "the risk assessment of this test"\n'
REGION = '[[region]]\nname = "chest"\nlinks = ["forearm_link"]\nquasi_static_force_n = 20\n'


def load(folder: Path, text: str) -> BodyLimits:
    file = folder / "limits.toml"
    file.write_text(text)
    return BodyLimits.load(file)


def test_the_file_that_comes_with_the_project_states_no_number() -> None:
    assert resources.files("robotskin.control").joinpath(EMPTY_FILE.name).is_file()
    empty = BodyLimits.load(EMPTY_FILE)
    assert empty.source == ""
    assert empty.regions == ()
    assert empty.for_skin(finished("ur5"), 0.35).regions == []


def test_the_template_and_the_page_name_every_field() -> None:
    page = (Path(__file__).parents[3] / "docs" / "control.md").read_text()
    for field in FIELDS:
        assert f"# {field} = " in EMPTY_FILE.read_text()
        assert f"\n{field} = " in page


def test_regions_are_cells_of_links_patches_and_single_ones(tmp_path: Path) -> None:
    layout = finished("ur5")
    single = int(layout.cells_on("shoulder_link")[0])
    patch = layout.patches[0].name
    limits = load(
        tmp_path,
        SOURCE
        + REGION
        + f'[[region]]\nname = "hand"\npatches = ["{patch}"]\ntransient_pressure_n_cm2 = 3.5\ntransient_s = 0.5\n'
        + f'[[region]]\nname = "head"\ncells = [[{layout.group[single]}, {layout.id[single]}]]\n'
        + "transient_force_n = 4\nquasi_static_force_n = 2.5\ntransient_s = 0.25\n",
    )
    chest, hand, head = limits.for_skin(layout, 0.35).regions
    assert chest.cells == sorted(layout.cells_on("forearm_link"))
    assert (chest.force.quasi_static, chest.force.transient) == (20, np.inf)
    assert hand.cells == list(np.flatnonzero(layout.patch == 0))
    assert (hand.pressure.transient, hand.transient_s) == (3.5, 0.5)
    assert head.cells == [single]
    assert (head.force.transient, head.force.quasi_static, head.transient_s) == (4, 2.5, 0.25)
    assert limits.source == "the risk assessment of this test"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (REGION, "source is empty"),
        ('source = "  "\n' + REGION, "source is empty"),
        ("source = 3\n", "source is 3"),
        (SOURCE + "regions = 1\n", "unknown entry 'regions'"),
        (SOURCE + '[region]\nname = "chest"\n', "double brackets"),
        (SOURCE + REGION + "quasi_static_force = 20\n", "region 1: unknown field quasi_static_force; there are name"),
        (SOURCE + REGION.replace("20", "-20"), r"region 1 \(chest\): quasi_static_force_n is -20.0"),
        (SOURCE + REGION.replace("20", "true"), "quasi_static_force_n is True"),
        (SOURCE + REGION.replace("20", '"20 N"'), "quasi_static_force_n is '20 N'"),
        (SOURCE + REGION.replace("20", "nan"), "quasi_static_force_n is nan"),
        (SOURCE + REGION.replace("20", "inf"), "quasi_static_force_n is inf"),
        (SOURCE + REGION.replace("quasi_static_force_n = 20", ""), "no limit: give at least one of"),
        (SOURCE + REGION + "transient_force_n = 40\n", "transient_force_n without transient_s"),
        (SOURCE + REGION.replace('links = ["forearm_link"]', ""), "no part of the robot"),
        (SOURCE + REGION.replace('["forearm_link"]', '"forearm_link"'), "must be a list of names"),
        (SOURCE + REGION + "cells = [1, 2]\n", r"must be a list of \[section unit, id\]"),
        (SOURCE + REGION.replace('name = "chest"', ""), "name is None"),
        (SOURCE + REGION + REGION, "2 regions of the name 'chest'"),
        ("source = ", "limits.toml"),
    ],
)
def test_mistakes_are_refused_by_name(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(BodyLimitsError, match=message):
        load(tmp_path, text.replace("= -20", "= -20.0"))


def test_what_the_robot_does_not_have_is_refused_with_the_choices(tmp_path: Path) -> None:
    layout = finished("ur5")
    with pytest.raises(UnknownNameError, match="did you mean forearm_link"):
        load(tmp_path, SOURCE + REGION.replace("forearm_link", "forearm")).for_skin(layout, 0.35)
    with pytest.raises(UnknownNameError, match="forearm_link_1"):
        load(tmp_path, SOURCE + REGION + 'patches = ["forearm_link_3"]\n').for_skin(layout, 0.35)
    with pytest.raises(BodyLimitsError, match="no cell 9999 of section unit 1; the skin of ur5 has section units 1"):
        load(tmp_path, SOURCE + REGION + "cells = [[1, 9999]]\n").for_skin(layout, 0.35)
