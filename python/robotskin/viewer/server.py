"""The web server under a page: bound to this machine, in the page's colours."""

import contextlib
import io

import viser

HOST = "127.0.0.1"
PANEL_WIDTH = 300


def open_server(title: str, port: int) -> viser.ViserServer:
    """Serve an empty page; `port` is the first one tried, the next free one is used where it is taken."""
    with contextlib.redirect_stdout(io.StringIO()):  # The address is the caller's to print.
        server = viser.ViserServer(host=HOST, port=port, label=title, verbose=False)
    server.gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False, brand_color=(64, 150, 220))
    server.gui.main_panel.dock_right()
    server.gui.main_panel.set_width(PANEL_WIDTH)
    return server


def close_server(server: viser.ViserServer) -> None:
    """Stop serving."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def address(server: viser.ViserServer) -> str:
    """What to type into a browser."""
    return f"http://{HOST}:{server.get_port()}"
