# SPDX-License-Identifier: Apache-2.0
"""The view of every browser: fitted to its screen as long as its person has not turned it."""

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


def fit_to_screens(server: viser.ViserServer, camera_at: Callable[[float], Camera]) -> None:
    """Give every browser, when it comes and when its screen changes its shape, the camera for its aspect."""

    @server.on_client_connect
    def _(client: viser.ClientHandle) -> None:
        # A slow browser still tells where it was before it was put elsewhere.
        ours_m: list[Floats] = [np.array(client.camera.position, dtype=float)]
        fitted: list[float] = []

        def fit() -> None:
            aspect = client.camera.aspect
            if fitted:
                here = client.camera.position
                near = TURNED_SHARE * float(np.linalg.norm(here - client.camera.look_at))
                turned = all(np.linalg.norm(here - place) > near for place in ours_m)
                if turned or abs(aspect / fitted[-1] - 1) < OTHER_SHAPE:
                    return
            camera = camera_at(aspect)
            fitted.append(aspect)
            ours_m.append(np.asarray(camera.position_m, dtype=float))
            _put(client, camera.position_m, camera.look_at_m)

        client.camera.on_update(lambda _: fit())
        fit()


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
