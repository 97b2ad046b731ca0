# SPDX-License-Identifier: Apache-2.0
"""Laws of a cell's ports as the page tells them: each names its neighbour, whether it works, and its own errors."""

import numpy as np
from stand_in import resting, stand_in_layout
from test_network_scene import reading

from robotskin.viewer.cell_card import cell_card
from robotskin.viewer.port_table import CHILD, PARENT, RESERVE, port_states, port_table


def test_a_port_names_neighbour_and_role() -> None:
    layout = stand_in_layout()
    first, middle = port_states(0, layout, reading()), port_states(5, layout, reading())
    assert [one.neighbour for one in middle] == ["cell 4, port 4", "", "", "cell 6, port 1"]
    assert [one.role for one in middle] == [PARENT, "", "", CHILD]
    assert [one.neighbour for one in first] == ["", "cable 7:1", "", "cell 1, port 1"]
    assert [one.role for one in first] == ["", PARENT, "", CHILD]
    turned = reading().parent_port.copy()
    turned[6] = 4
    assert port_states(5, layout, reading(parent_port=turned))[3].role == RESERVE


def test_a_port_counts_the_damaged_frames_of_both_its_ends() -> None:
    layout = stand_in_layout()
    damaged = np.zeros((len(layout), 4), dtype=int)
    damaged[5] = (3, 0, 0, 11)
    damaged[4, 3], damaged[6, 0], damaged[0, 1] = 7, 1234, 2
    moment = reading(damaged=damaged)
    assert [(one.damaged, one.damaged_there) for one in port_states(5, layout, moment)] == [
        (3, 7),
        (None, None),
        (None, None),
        (11, 1234),
    ]
    assert (port_states(0, layout, moment)[1].damaged, port_states(0, layout, moment)[1].damaged_there) == (2, None)
    assert 'data-port="4" data-link="up" data-role="child" data-damaged="11"' in port_table(5, layout, moment)
    assert "1,234" in port_table(5, layout, moment)


def test_a_port_that_does_not_work_says_why_and_has_no_role() -> None:
    layout = stand_in_layout()
    alive, cut = reading().alive.copy(), reading().cut.copy()
    alive[6] = False
    cut[5, 0] = cut[4, 3] = cut[0, 1] = True
    moment = reading(alive=alive, cut=cut)
    ports = port_states(5, layout, moment)
    assert [(one.trouble, one.role) for one in ports] == [("cut", ""), ("", ""), ("", ""), ("neighbour dead", "")]
    assert port_states(0, layout, moment)[1].trouble == "cut"
    assert {one.trouble for one in port_states(6, layout, moment) if one.neighbour} == {"cell dead"}
    assert 'data-link="down"' in port_table(5, layout, moment)


def test_the_card_of_a_session_has_the_ports_where_the_network_is_seen() -> None:
    layout = stand_in_layout()
    cable = reading().cable
    assert "data-ports-of" not in cell_card(5, layout, cable, resting(len(layout)))
    assert 'data-ports-of="5"' in cell_card(5, layout, cable, resting(len(layout)), reading())
