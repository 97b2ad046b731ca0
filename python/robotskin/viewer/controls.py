"""The commanding half of the page: how to touch, how the robot answers, and what the colours mean."""

from collections.abc import Callable

import viser

from robotskin.viewer.colours import MODALITIES
from robotskin.viewer.legend import legend
from robotskin.viewer.session_view import INTERFACES, MODES, Integers, SessionView, Snapshot

PUSH, APPROACH, LOOK = "pushes", "brings a hand near", "only looks"
HINT = {
    PUSH: "Click a cell to push it; drag from a cell: the further, the harder.",
    APPROACH: "Click a cell to bring a hand near it; drag the arrow to move the hand.",
    LOOK: "Click a cell to see its numbers; nothing touches the robot.",
}


class Controls:
    """Fills the panel on the right. `command(action)` runs what a person asked for and reports what it refuses."""

    def __init__(
        self,
        server: viser.ViserServer,
        session: SessionView,
        cable: Integers,
        command: Callable[[Callable[[], None]], None],
    ) -> None:
        self.session = session
        gui = server.gui
        snapshot = session.snapshot()
        with gui.add_folder("Touch"):
            self._tool = gui.add_dropdown("A click", (PUSH, APPROACH, LOOK), initial_value=PUSH)
            self._hint = gui.add_markdown(_hint(PUSH))
            self.force = gui.add_slider("Force [N]", 1.0, 30.0, 0.5, 15.0)
            self.hold = gui.add_checkbox("Until released", False, hint="A push lasts until the hand is taken away.")
            self.duration = gui.add_slider("Lasts [s]", 0.5, 10.0, 0.5, 2.0)
            self.distance = gui.add_slider("Hand at [cm]", 0.0, 30.0, 0.5, 6.0, visible=False)
            release = gui.add_button("Take the hand away", icon=viser.Icon.HAND_OFF)
        with gui.add_folder("Robot"):
            self._interface = gui.add_dropdown("Interface", INTERFACES, initial_value=snapshot.interface)
            self._mode = gui.add_dropdown("Cells send", MODES, initial_value=snapshot.mode)
            self._skin = gui.add_checkbox("Skin moves the robot", snapshot.skin_on)
            reset = gui.add_button("Reset", icon=viser.Icon.RESTORE, color="gray")
        with gui.add_folder("Colour"):
            self._modality = gui.add_dropdown("Cells by", MODALITIES, initial_value="force")
            self._legend = gui.add_html(legend("force", session.layout, cable))
            self._cables = gui.add_checkbox("Cables", False, visible=bool(session.layout.cables))

        @self._tool.on_update
        def _(_: viser.GuiEvent) -> None:
            self._show_tool()

        @self.hold.on_update
        def _(_: viser.GuiEvent) -> None:
            self._show_tool()

        @self._modality.on_update
        def _(_: viser.GuiEvent) -> None:
            self._legend.content = legend(self._modality.value, session.layout, cable)

        # The person's wishes only: values that the page itself sets carry no client.
        def on_wish(handle: viser.GuiInputHandle, action: Callable[[], None]) -> None:
            @handle.on_update
            def _(event: viser.GuiEvent) -> None:
                if event.client is not None:
                    command(action)

        on_wish(self._interface, lambda: session.set_interface(self._interface.value))
        on_wish(self._mode, lambda: session.set_mode(self._mode.value))
        on_wish(self._skin, lambda: session.set_skin(self._skin.value))
        release.on_click(lambda _: command(session.release))
        reset.on_click(lambda _: command(session.reset))
        self.release = release

    @property
    def tool(self) -> str:
        """What a click on a cell does: `PUSH`, `APPROACH` or `LOOK`."""
        return self._tool.value

    @property
    def modality(self) -> str:
        """What the cells are coloured by."""
        return self._modality.value

    @property
    def cables(self) -> bool:
        """Whether the cables of the section units are drawn."""
        return self._cables.value

    @property
    def duration_s(self) -> float | None:
        """How long a push lasts; None: until it is released."""
        return None if self.hold.value else float(self.duration.value)

    def update(self, snapshot: Snapshot) -> None:
        """Show what the session does now, whoever asked for it."""
        for handle, value in (
            (self._interface, snapshot.interface),
            (self._mode, snapshot.mode),
            (self._skin, snapshot.skin_on),
        ):
            if handle.value != value:
                handle.value = value  # type: ignore[misc]

    def use(self, tool: str) -> None:
        """Choose what a click does."""
        self._tool.value = tool  # type: ignore[misc]
        self._show_tool()

    def show_distance(self, distance_m: float) -> None:
        """Show where a dragged hand was left."""
        self.distance.value = round(distance_m * 200) / 2  # type: ignore[misc]

    def _show_tool(self) -> None:
        self._hint.content = _hint(self.tool)
        self.force.visible = self.hold.visible = self.tool == PUSH
        self.duration.visible = self.tool == PUSH and not self.hold.value
        self.distance.visible = self.tool == APPROACH


def _hint(tool: str) -> str:
    return f"<sub>{HINT[tool]}</sub>"
