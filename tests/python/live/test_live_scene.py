# SPDX-License-Identifier: Apache-2.0
"""A session with a scene: the page is shown every thing where the world has it, each in a colour of its own."""

import queue
import threading

import numpy as np
import pytest
import viser

from robotskin import robots
from robotskin.layout import finished
from robotskin.live.live_session import LiveSession
from robotskin.session import Session
from robotskin.viewer.solids import Solids
from robotskin.world import load_scene


def test_things_are_shown_where_they_are(seed):
    session = Session(
        robots.load("ur5"), finished("ur5"), seed=seed, link="in process", scene=load_scene("table_with_things")
    )
    session.boot()
    looked: queue.SimpleQueue[str] = queue.SimpleQueue()
    with LiveSession(session) as live:
        live.look_with_snapshots(lambda: looked.put(threading.current_thread().name))
        assert looked.get(timeout=60) == "session", "what a page copies is not written meanwhile"
        snapshot = live.snapshot()
        names = [solid.name for solid in live.solids]
        assert names == ["floor", "table", "ball", "box", "can", "orange"]
        shown = [solid.colour for solid in live.solids]
        assert len(set(shown)) == len(shown)
        for name, pose in zip(names, snapshot.solids, strict=True):
            if name != "floor":
                thing = session.world.thing(name)
                assert pose[:3, 3] == pytest.approx(thing.position_m, abs=0.002)
        box = live.solids[names.index("box")].mesh
        assert box.extents == pytest.approx([0.08, 0.06, 0.10])
        solids = Solids(viser.ViserServer(port=0, verbose=False), live.solids)
        solids.move(snapshot.solids)
        assert np.asarray(solids.frames[2].position) == pytest.approx(snapshot.solids[2, :3, 3])
