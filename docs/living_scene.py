# SPDX-License-Identifier: Apache-2.0
"""Makes docs/living/push.html: a skinned UR5 that is pushed on three links, in a file that opens without a server."""

import tempfile
from pathlib import Path

import numpy as np

from robotskin import layout, robots
from robotskin.record import Recorder, Recording
from robotskin.session import Session
from robotskin.viewer.exported_scene import scene_html
from robotskin.viewer.recorded_scene import recorded_frames

FILE = Path(__file__).with_name("living") / "push.html"
TOWARDS_VIEWER = np.array([0.6, -0.6, 0.5])
LINKS = ("forearm_link", "wrist_2_link", "upper_arm_link")


def facing_cell(session: Session, link: str) -> int:
    """The cell of a link whose outside is seen best."""
    cells = [cell for cell in range(len(session.layout)) if session.layout.links[session.layout.link[cell]] == link]
    outward = [session.world.base_from_cell(session.in_world(cell))[:3, 2] @ TOWARDS_VIEWER for cell in cells]
    return cells[int(np.argmax(outward))]


def make() -> str:
    """The page."""
    robot, skin = robots.load("ur5"), layout.finished("ur5")
    session = Session(robot, skin, seed=1)
    session.boot()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "push.mcap"
        with Recorder(file, session):
            for link in LINKS:
                session.run(0.3)
                session.world.push(cell=facing_cell(session, link), force_n=15.0)
                session.run(1.2)
                session.world.release()
                session.run(0.8)
        session.shut_down()
        return scene_html("robotskin: a push", robot, skin, recorded_frames(Recording(file), frames_per_s=15))


if __name__ == "__main__":
    FILE.write_text(make(), encoding="utf-8")
    print(f"{FILE}: {FILE.stat().st_size / 1e6:.2f} MB")
