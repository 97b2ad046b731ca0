# SPDX-License-Identifier: Apache-2.0
"""The benchmark set of the network: what was fixed stays, and every skin is what its kind promises."""

import numpy as np
import pytest

from robotskin.layout.errors import LayoutError
from robotskin_lab.bench import network_set
from robotskin_lab.bench.network_set import COMPACT, KINDS, MISSING_LINKS, PORTS, skins


@pytest.mark.parametrize("kind", KINDS)
def test_the_set_is_the_one_that_was_committed(kind):
    committed = network_set.committed_digests()
    assert network_set.digests(kind) == {f"{kind} {ports}": committed[f"{kind} {ports}"] for ports in PORTS}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("ports", PORTS)
def test_a_skin_is_sound(kind, ports, seed):
    skin = skins(kind, ports, seed % 100)
    here = np.argwhere(skin.neighbours[:, :, 0] >= 0)
    other, port = skin.neighbours[here[:, 0], here[:, 1]].T
    np.testing.assert_array_equal(skin.neighbours[other, port - 1], here + np.array([0, 1]))
    assert len(np.unique(skin.id)) == len(skin)
    assert len({cable.cell for cable in skin.cables}) == len(skin.cables)
    for cable in skin.cables:
        assert skin.neighbours[cable.cell, cable.cell_port - 1, 0] < 0
    # Every part of a skin has a cable.
    assert set(skin.part[skin.roots]) == set(skin.part)
    assert sum(len(unit) for unit in units_of(skin)) == len(skin.cables)


def units_of(skin):
    places = {(cable.group, cable.unit): [] for cable in skin.cables}
    for cable in skin.cables:
        places[cable.group, cable.unit].append(cable.port)
    for ports in places.values():
        assert sorted(ports) == list(range(1, len(ports) + 1))
    assert len(skin.unit_descriptions()) == len(places)
    return list(places.values())


@pytest.mark.parametrize("kind", COMPACT)
@pytest.mark.parametrize("ports", PORTS)
def test_a_compact_skin_has_66_cells_a_port_and_hangs_together(kind, ports, seed):
    skin = skins(kind, ports, seed % 100)
    assert len(skin) == 66 * ports
    assert len(skin.cables) == ports
    assert skin.part.max() == 0


def test_cylinders_lack_links_and_are_whole_without_them(seed):
    intact = 2 * 198 - 11
    found = [len(skins("cylinder", 3, which % 100).links) for which in range(seed, seed + 10)]
    assert np.mean(found) == pytest.approx((1 - MISSING_LINKS) * intact, rel=0.02)


def test_bridges_join_the_patches_of_a_robot(seed):
    skin = skins("robot_1260", 3, seed % 100)
    first, second = skin.links[:, 0], skin.links[:, 2]
    assert (skin.patch[first] != skin.patch[second]).sum() == 2 * 47
    assert len(np.unique(skin.patch)) == 47
    assert len(skin) == 1260


def test_one_more_seed_is_another_skin():
    assert network_set.digest(iter([skins("sheet", 3, 0)])) != network_set.digest(iter([skins("sheet", 3, 1)]))


def test_limbs_are_apart_and_alike():
    skin = network_set.limbs(3)
    assert len(skin) == 750
    assert skin.part.max() == 2
    assert len(skin.unit_descriptions()) == 3
    assert not network_set.sheet_10k().part.any()


def test_an_unknown_kind_is_named():
    with pytest.raises(LayoutError, match=r"'sphere'.*sheet"):
        skins("sphere")
