# SPDX-License-Identifier: Apache-2.0
"""The pages of a fleet: a robot is seen, followed and stopped from a browser."""

from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from browsing import free_port, insist, opened, picture, wait_for

pytest.importorskip("zenoh")

from fleet_of_two import FleetOfTwo

from robotskin import layout, robots
from robotskin.fleet.followed import FollowedRobot
from robotskin.fleet.published import Told, published
from robotskin.fleet.table import rows, stop_told
from robotskin.fleet.watch import FleetWatch
from robotskin.live.followed_skin import FollowedSkin
from robotskin.session import Session
from robotskin.sharing.shared import shared
from robotskin.viewer.fleet_page import FleetPage
from robotskin.viewer.followed_page import FollowedPage
from robotskin.viewer.scene import SHADOWS

if TYPE_CHECKING:
    from playwright import sync_api

ROBOT, CELL = "allegro_right_hand", 40


def test_a_robot_is_seen_followed_and_stopped(
    browser: "sync_api.Browser", tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    monkeypatch.setenv(SHADOWS, "off")
    fleet = FleetOfTwo(tmp_path)
    session = Session(robots.load(ROBOT), layout.finished(ROBOT), seed=seed, link="in process")
    session.boot()
    stopped: list[str] = []

    def look() -> Told:
        return Told("skin_compliance", "stopped" if stopped else "running", ill={"stuck": 2})

    robot = published(fleet.member("left"), session, look, stopped.append)
    with FleetWatch(fleet.member("desk")) as watch, shared(session, [robot], also=[robot]):
        wait_for(lambda: robot.connected, "the robot is not in the fleet")
        session.world.push(CELL, 6.0)

        def live() -> bool:
            session.run(0.05)
            return watch.robots()["left"].state is not None and bool(watch.robots()["left"].state.contacts)

        wait_for(lambda: "left" in watch.robots() and live(), "the touch is not told")
        with FleetPage(
            lambda: rows(watch.robots(), watch.robots()["left"].heard_s, True),
            lambda name: stop_told(watch, None if name is None else [name]), "fleet", free_port(),
        ) as served:  # fmt: skip
            page = opened(browser, served.address)
            card = page.locator("[data-robot='left']")
            wait_for(lambda: "2 stuck" in card.inner_text(), "the robot is not seen")
            assert all(told in card.inner_text() for told in ("skin_compliance: running", "100% (62 of 62)", " N"))
            for width, height in ((390, 844), (1000, 560)):
                page.set_viewport_size({"width": width, "height": height})

                def fits(width: int = width, height: int = height) -> bool:
                    stop, told = page.get_by_role("button", name="STOP ALL").bounding_box(), card.bounding_box()
                    if stop is None or told is None:
                        return False
                    in_sight = stop["y"] + stop["height"] < height / 2
                    return in_sight and stop["width"] > 0.9 * width and told["width"] > 250

                wait_for(fits, f"stop is out of sight on a screen of {width} x {height}")
            insist(
                lambda: page.get_by_role("button", name="STOP ALL").click(), lambda: stopped, "the robot is not stopped"
            )
            answer = page.locator("[data-answer]")
            wait_for(lambda: "left: obeyed after" in answer.inner_text(), "no answer is shown")
            wait_for(lambda: "skin_compliance: stopped" in card.inner_text(), "the state is not shown")
            picture(page, "fleet")
            page.close()
        with FollowedRobot(fleet.member("screen"), "left") as followed:
            skin = FollowedSkin(followed)

            def felt() -> bool:
                session.run(0.05)
                reading = skin.reading()
                return reading is not None and float(reading.normal_force.sum()) > 1.0

            wait_for(felt, "the touch is not felt from afar")
            with FollowedPage(skin, "left", free_port()) as served:
                page = opened(browser, served.address)
                link = page.locator("[data-link]")
                wait_for(lambda: felt() and "live from left" in link.inner_text(), "the page says not that it is live")
                wait_for(lambda: "nothing heard from left" in link.inner_text(), "the page shows as fresh what is not")
                picture(page, "followed")
                page.close()
    session.shut_down()
    fleet.close()
