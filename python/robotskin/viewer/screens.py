# SPDX-License-Identifier: Apache-2.0
"""The view of every browser: fitted to its screen as long as its person has not turned it."""

import threading
import time
from collections.abc import Callable

import numpy as np
import viser

from robotskin.viewer.camera import Camera
from robotskin.viewer.session_view import Floats

OTHER_SHAPE = 0.02
"""A screen whose aspect changes by this share is fitted again."""
TURNED_SHARE = 1e-3
"""Of the distance: farther than that from where it was put, the view is its person's."""
UPWARDS = 0.35
AGAIN_S = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
"""After so long each, a browser that has not told where it is is told again where to be."""
NUDGE_M = 1e-3
"""Less than counts as turned, and yet another place."""


def fit_to_screens(server: viser.ViserServer, camera_at: Callable[[float], Camera]) -> None:
    """Give every browser, when it comes and when its screen changes its shape, the camera for its aspect."""
    opening_m = server.initial_camera.position
    server.on_client_connect(lambda client: _Fitting(client, camera_at, np.array(opening_m, dtype=float)).begin())


class _Fitting:
    """Fits the view of one browser.

    A slow one still tells where it was before it was put elsewhere, may go back to where it opened, and may lose what
    it is told while it opens, or understand it in a world that has not been turned upright yet. It is told again until
    it says that it is where it was put. From then on, any other place is one that its person turned it to.
    """

    def __init__(self, client: viser.ClientHandle, camera_at: Callable[[float], Camera], opening_m: Floats) -> None:
        self.client, self.camera_at = client, camera_at
        # Where a page opens, and where this browser was when it came, which may be before or after.
        self.openings_m: tuple[Floats, ...] = (opening_m, np.array(client.camera.position, dtype=float))
        self.put: list[tuple[float, Camera]] = []
        self.arrived = False
        """Where it was put last."""
        self.has_arrived_once = False

    def begin(self) -> None:
        self.client.camera.on_update(lambda _: self.heard())
        self.fit()

    def heard(self) -> None:
        """The browser tells where it is, and what shape its screen has."""
        if not self.put:  # it tells so while it is put somewhere for the first time
            return
        aspect, camera = self.put[-1]
        there = self.is_at(camera.position_m)
        self.arrived = self.arrived or there
        self.has_arrived_once = self.has_arrived_once or there
        went_back = self.has_just_opened() and not there
        other_shape = abs(self.client.camera.aspect / aspect - 1) >= OTHER_SHAPE
        if (went_back or other_shape) and self.is_ours():
            self.fit()

    def is_at(self, place_m: Floats) -> bool:
        here = self.client.camera.position
        distance = float(np.linalg.norm(here - self.client.camera.look_at))
        return float(np.linalg.norm(here - place_m)) <= TURNED_SHARE * distance

    def has_just_opened(self) -> bool:
        """It is where it was before it was put anywhere."""
        return any(self.is_at(opening_m) for opening_m in self.openings_m)

    def is_ours(self) -> bool:
        """Where it opened or was ever put, or not come to such a place yet: its person has not turned it."""
        if not self.has_arrived_once:
            return True
        return self.has_just_opened() or any(self.is_at(camera.position_m) for _, camera in self.put)

    def fit(self) -> None:
        aspect = self.client.camera.aspect
        camera = self.camera_at(aspect)
        self.put.append((aspect, camera))
        self.arrived = False
        _put(self.client, camera.position_m, camera.look_at_m)
        threading.Thread(target=self.insist, args=(camera,), name="view of a browser", daemon=True).start()

    def insist(self, camera: Camera) -> None:
        """Tell the browser again, as long as this is the view that it is to have."""
        for wait_s in AGAIN_S:
            time.sleep(wait_s)
            if self.arrived or camera is not self.put[-1][1] or not self.is_ours():
                return
            # A place that is no other than the one before is not sent.
            _put(self.client, camera.position_m + NUDGE_M, camera.look_at_m)
            _put(self.client, camera.position_m, camera.look_at_m)


def see_all(server: viser.ViserServer, camera_at: Callable[[float], Camera]) -> None:
    """Give every browser the camera for its aspect, wherever it looks now."""
    for client in server.get_clients().values():
        camera = camera_at(client.camera.aspect)
        _put(client, camera.position_m, camera.look_at_m)


def look_at(server: viser.ViserServer, point_m: Floats, normal: Floats, distance_m: float | None = None) -> None:
    """Let every browser look at a point (3,) along its normal (3,), a little from above, from this far; None: from as
    far as before."""
    for client in server.get_clients().values():
        distance = distance_m or float(np.linalg.norm(client.camera.position - client.camera.look_at))
        towards = np.add(normal, (0.0, 0.0, UPWARDS))
        _put(client, point_m + distance * towards / np.linalg.norm(towards), point_m)


def _put(client: viser.ClientHandle, position_m: Floats, look_at_m: Floats) -> None:
    with client.atomic():
        client.camera.position = np.asarray(position_m, dtype=float)
        client.camera.look_at = np.asarray(look_at_m, dtype=float)
