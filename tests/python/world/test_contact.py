# SPDX-License-Identifier: Apache-2.0
"""What the cells feel adds up to what MuJoCo says, wherever a hand presses."""

import mujoco
import numpy as np
import pytest

from robotskin.layout.cell import PORT_POINTS_M
from robotskin.world import HandSpec, Imperfections, SceneSpec, ThingSpec, WorldError
from robotskin.world.things import Sphere

FULL_SCALE_N = 10.0
COUNT_N = FULL_SCALE_N / 1024


def place(kind: str, skin, generator) -> tuple[int, tuple[float, float]]:
    """A cell and a point of it: its middle, a seam with a neighbour, or the patch's edge."""
    if kind == "cell":
        return int(generator.integers(len(skin))), (0.0, 0.0)
    wanted = skin.neighbours[:, :, 0] >= 0 if kind == "seam" else skin.neighbours[:, :, 0] < 0
    cell, port = generator.choice(np.argwhere(wanted))
    x, y = PORT_POINTS_M[port][:2]
    return int(cell), (float(x), float(y))


@pytest.mark.parametrize("kind", ["cell", "seam", "edge"])
def test_cells_sum_is_the_contact_force(make_body, skin, generator, kind):
    world = make_body()
    pressed = 0
    for _ in range(6):
        cell, at = place(kind, skin, generator)
        world.push(cell, 15.0, at)
        for _ in range(20):
            world.step(0.05)
            contact, felt = world.contact_normal_force(), world.cell_true_force()
            assert felt.sum() == pytest.approx(contact.sum(), rel=1e-9, abs=1e-12)
            assert (felt >= 0).all()
        if contact[0] > 0:  # else a bare link was in the way
            pressed += 1
            # Contacts that are tilted to the push need more normal force than it, never less.
            assert 14.5 < contact[0] < 40
        world.release()
        world.step(0.6)
        assert world.cell_true_force().sum() == 0
    assert pressed >= 3


def test_fifteen_newton_press_a_cell_in_by_millimetres_and_fit_its_range(make_body, generator, skin):
    world = make_body()
    for cell in generator.choice(len(skin), 5, replace=False):
        world.push(int(cell), 15.0)
        world.step(1.2)
        data = world.scene.data
        depth = -min(data.contact[i].dist for i in range(data.ncon))
        assert 0.001 < depth < 0.003
        assert world.cell_true_force().max() < FULL_SCALE_N
        world.release()
        world.step(0.6)


def test_several_hands_and_a_thing_press_independently(make_body, skin, generator):
    ball = ThingSpec(name="ball", shape=Sphere(radius_m=0.04), mass_kg=0.3, position_m=(0, 0, -1))
    hands = (HandSpec(), HandSpec(0.02, 0.3), HandSpec(0.05, 1.0))
    world = make_body(hands=hands, scene=SceneSpec(things=(ball,)))
    up = np.argmax(world.base_from_cell()[:, 2, 2])
    top = world.base_from_cell(int(up))
    world.thing("ball").put(top[:3, 3] + top[:3, 2] * 0.041)
    cells = generator.choice(np.delete(np.arange(len(skin)), up), 3, replace=False)
    for hand, cell in enumerate(cells):
        world.push(int(cell), 5.0 + hand, hand=hand)
    touched_by_ball = False
    for _ in range(40):
        world.step(0.03)
        contact = world.contact_normal_force()
        assert world.cell_true_force().sum() == pytest.approx(contact.sum(), rel=1e-9, abs=1e-12)
        touched_by_ball = touched_by_ball or contact[3] > 0
    assert touched_by_ball
    assert (contact[:3] > 0).all()


def test_force_is_shared_by_the_sensors_that_are_near(make_body, skin):
    world = make_body()
    shares = []
    for at in ((0.0, 0.0065), (-0.005629, -0.00325), (0.005629, -0.00325)):
        world.push(140, 6.0, at)
        world.step(1.0)
        shares.append(world.cell_true_force()[140])
    assert [int(np.argmax(share)) for share in shares] == [0, 1, 2]
    for share in shares:
        assert 0.45 * share.sum() < share.max() < 0.55 * share.sum()


def test_counts_are_within_half_a_count_of_the_truth_when_sensors_are_ideal(make_body):
    world = make_body(imperfections=Imperfections.none())
    world.push(140, 12.0)
    world.step(1.0)
    counts = np.array(world.body.sample(140, 10**9)[1:4])
    assert np.abs(counts * COUNT_N - world.cell_true_force()[140]).max() <= COUNT_N / 2 + 1e-12


def test_beyond_ten_newton_a_sensor_is_saturated_and_counted(make_body):
    world = make_body(imperfections=Imperfections.none())
    world.push(140, 25.0, (0.0, 0.0065))
    world.step(1.0)
    before = world.body.saturated_samples
    assert max(world.body.sample(140, 10**9)[1:4]) == 1023
    assert world.body.saturated_samples == before + 1


def test_imperfect_cells_still_balance_within_five_percent(make_body, skin, generator):
    world = make_body()
    for kind in ("cell", "seam", "edge"):
        cell, at = place(kind, skin, generator)
        world.push(cell, 15.0, at)
        world.step(1.2)
        pressed = np.flatnonzero(world.cell_true_force().sum(axis=1) > 0)
        felt = sum(np.sum(world.body.sample(int(i), 10**9)[1:4]) for i in pressed) * COUNT_N
        assert felt == pytest.approx(world.contact_normal_force()[0], rel=0.05)
        world.release()
        world.step(0.6)


def test_a_world_of_which_mujoco_warns_goes_no_further(make_body):
    """As where its arena is full: contacts are left out, and no figure may come of that."""
    world = make_body()
    world.step(0.01)
    world.scene.data.warning[mujoco.mjtWarning.mjWARN_CNSTRFULL].number = 1
    with pytest.raises(WorldError, match=r"mjWARN_CNSTRFULL 1 times up to 0\.02"):
        world.step(0.01)
