# SPDX-License-Identifier: Apache-2.0
"""The commanding half of the page: how to touch, how the robot answers, and what the colours mean."""

from collections.abc import Callable
from html import escape
from typing import Any

import viser

from robotskin.choices import INTERFACES
from robotskin.viewer.colours import MODALITIES
from robotskin.viewer.goal_panel import GoalPanel
from robotskin.viewer.legend import PADDING, legend
from robotskin.viewer.session_view import Integers, Recordable, SessionView, Snapshot, StoppedByHand

# How long a session may take to do as it is told before the page shows what it does instead.
WISH_S = 2.0

PUSH, APPROACH, LOOK = "pushes it", "brings a hand near", "only looks"
HINT = {
    PUSH: "Click a cell to push it. Drag from a cell: the further, the harder.",
    APPROACH: "Click a cell to bring a hand near it. Drag the arrow to move the hand.",
    LOOK: "Click a cell to see its numbers; nothing touches the robot.",
}
MODE_WORDS = {"clock": "at a fixed rate", "event": "only what changes"}
SOURCE_WORDS = {"host": "this computer", "skin": "the cells"}
COLOUR_HINT = "What the colours of the cells stand for: what they measure, or how they are wired."


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
        self._cable = cable
        self._build(server, session.snapshot(), command)
        session_set = session.set_behaviour
        names = {in_words(name): name for name in session.behaviours}
        modes = {words: name for name, words in MODE_WORDS.items()}
        sources = {words: name for name, words in SOURCE_WORDS.items()}
        self._switches: dict[str, _Switch] = {
            "behaviour": _Switch(self.behaviour, lambda words: session_set(names.get(words, words)), command, in_words),
            "interface": _Switch(self.interface, session.set_interface, command),
            "mode": _Switch(self._mode, lambda words: session.set_mode(modes[words]), command, MODE_WORDS.__getitem__),
            "source": _Switch(
                self._source, lambda words: session.set_source(sources[words]), command, SOURCE_WORDS.__getitem__
            ),
            "skin_on": _Switch(self._skin, session.set_skin, command),
        }

    def _build(
        self, server: viser.ViserServer, snapshot: Snapshot, command: Callable[[Callable[[], None]], None]
    ) -> None:
        gui, session = server.gui, self.session
        real = isinstance(session, StoppedByHand)  # is touched by real hands
        tool = LOOK if real else PUSH
        with gui.add_folder("Touch", visible=not real):
            self._hint = gui.add_html(_hint(tool))
            self._tool = gui.add_dropdown(
                "A click", (PUSH, APPROACH, LOOK), initial_value=tool, hint="What a click on a cell of the skin does."
            )
            self.force = gui.add_slider(
                "Force [N]",
                1.0,
                30.0,
                0.5,
                15.0,
                hint="How hard the hand pushes. 10 N is the weight of a litre of milk.",
            )
            self.duration = gui.add_slider("Lasts [s]", 0.5, 10.0, 0.5, 2.0, hint="How long a push lasts.")
            self.hold = gui.add_checkbox("Until released", False, hint="A push lasts until the hand is taken away.")
            self.distance = gui.add_slider(
                "Hand at [cm]", 0.0, 30.0, 0.5, 6.0, visible=False, hint="How far from the cell the hand stops."
            )
            self.release = gui.add_button("Take the hand away", icon=viser.Icon.HAND_OFF)
            self.turn = gui.add_button(
                "Turn to the cell",
                icon=viser.Icon.EYE,
                color="gray",
                visible=False,
                hint="Look at the chosen cell from its own side.",
            )
        with gui.add_folder("Robot"):
            names = tuple(in_words(name) for name in session.behaviours)
            present = in_words(snapshot.behaviour)
            self.behaviour = gui.add_dropdown(
                "Behaviour",
                (*names, *(() if present in names else (present,))),
                initial_value=present,
                visible=bool(names),
                hint="What the robot does, and how it answers to touch.",
            )
            self._meaning = gui.add_html("", visible=bool(names))
            self._skin = gui.add_checkbox(
                "Feels touch", snapshot.skin_on, hint="Off: the robot does not answer to what its skin feels."
            )
            reset = gui.add_button(
                "Back to the start",
                icon=viser.Icon.RESTORE,
                color="gray",
                hint="Take the hand away, go home, and start again if the robot has stopped.",
            )
        with gui.add_folder("Colours"):
            self._modality = gui.add_dropdown("Cells by", MODALITIES, initial_value="force", hint=COLOUR_HINT)
            self._legend = gui.add_html(legend("force", session.layout, self._cable))
            self._cables = gui.add_checkbox(
                "Cables", False, visible=bool(session.layout.cables), hint="Draw the cables from the skin to its units."
            )
        self.goal = GoalPanel(server, session, command)
        with gui.add_folder("Inside", expand_by_default=False):
            self.interface = gui.add_dropdown(
                "Motors obey",
                INTERFACES if snapshot.interface in INTERFACES else (*INTERFACES, snapshot.interface),
                initial_value=snapshot.interface,
                hint="What the motors are told: where to be, how fast to turn, or with what torque.",
            )
            self._mode = gui.add_dropdown(
                "Cells send",
                tuple(MODE_WORDS.values()),
                initial_value=MODE_WORDS[snapshot.mode],
                hint="All cells at a fixed rate (clock mode), or each when what it feels changes (event mode).",
            )
            self._source = gui.add_dropdown(
                "Touch adds up in",
                tuple(SOURCE_WORDS.values()),
                initial_value=SOURCE_WORDS[snapshot.source],
                hint="What computes the torques of touch: this computer from all cells, or the cells on the way.",
            )
            self._source_refused = gui.add_html("", visible=False)
        self._recording: viser.GuiHtmlHandle | None = None
        if isinstance(session, Recordable):
            self._record_parts(server, session, command)
        self.release.on_click(lambda _: command(session.release))
        reset.on_click(lambda _: command(session.reset))
        if isinstance(session, StoppedByHand):
            stop = gui.add_button(
                "Stop", color="red", order=-2, hint="The robot stops smoothly and holds; Back to the start goes on."
            )
            stop.on_click(lambda _: command(session.stop))
            confirm = gui.add_button(
                "Confirm speed", order=-1, hint="It does what it should: let it use its full speed."
            )
            confirm.on_click(lambda _: command(session.confirm))

        @self._tool.on_update
        def _(_: viser.GuiEvent) -> None:
            self._show_tool()

        @self.hold.on_update
        def _(_: viser.GuiEvent) -> None:
            self._show_tool()

        @self._modality.on_update
        def _(_: viser.GuiEvent) -> None:
            self.show_legend(self._cable)

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

    def _record_parts(
        self, server: viser.ViserServer, session: Recordable, command: Callable[[Callable[[], None]], None]
    ) -> None:
        with server.gui.add_folder("Recording", expand_by_default=False):
            record = server.gui.add_checkbox(
                "Record", False, hint="Keep all that is felt and done in a file; robotskin replay plays it."
            )
            self._recording = server.gui.add_html("")

        @record.on_update
        def _(event: viser.GuiEvent) -> None:
            if event.client is not None:
                on = bool(record.value)
                command(lambda: session.record(on))

    def update(self, snapshot: Snapshot, now_s: float) -> None:
        """Show what the session does now, whatever asked for it; `now_s` is the wall clock's, of any origin."""
        for name, switch in self._switches.items():
            switch.show(getattr(snapshot, name), now_s)
        if self._recording is not None and isinstance(self.session, Recordable):
            told = _small(escape(self.session.recording))
            if self._recording.content != told:
                self._recording.content = told
        self._offer_source(snapshot)
        self.goal.update(snapshot.goal)
        meaning = _small(_sentence(self.session.behaviours.get(snapshot.behaviour, "does as it was told")))
        if self._meaning.content != meaning:
            self._meaning.content = meaning

    def _offer_source(self, snapshot: Snapshot) -> None:
        """Let the torque's source be chosen where there is a choice, and say why where there is none."""
        refused = snapshot.source_refused
        if self._source.disabled != bool(refused):
            self._source.disabled = bool(refused)
        told = _small(f"Only this computer: {in_words(refused)}.")
        if refused and self._source_refused.content != told:
            self._source_refused.content = told
        if self._source_refused.visible != bool(refused):
            self._source_refused.visible = bool(refused)

    def use(self, tool: str) -> None:
        """Choose what a click does."""
        self._tool.value = tool  # type: ignore[misc]
        self._show_tool()

    def choose(self, modality: str) -> None:
        """Colour the cells by another modality."""
        self._modality.value = modality  # type: ignore[misc]
        self.show_legend(self._cable)

    def show_legend(self, cable: Integers) -> None:
        """Say what the colours mean; `cable` (N,) is the one each cell reports through."""
        self._cable = cable
        self._legend.content = legend(self.modality, self.session.layout, cable)

    def show_distance(self, distance_m: float) -> None:
        """Show where a dragged hand was left."""
        self.distance.value = round(distance_m * 200) / 2  # type: ignore[misc]

    def _show_tool(self) -> None:
        self._hint.content = _hint(self.tool)
        self.force.visible = self.hold.visible = self.tool == PUSH
        self.duration.visible = self.tool == PUSH and not self.hold.value
        self.distance.visible = self.tool == APPROACH


class _Switch:
    """A setting that a person wishes and the session has: the page shows the wish until the session had its time."""

    def __init__(
        self,
        handle: viser.GuiDropdownHandle[str] | viser.GuiCheckboxHandle,
        obey: Callable[[Any], None],
        command: Callable[[Callable[[], None]], None],
        written: Callable[[Any], Any] = lambda value: value,
    ) -> None:
        self._handle = handle
        self._written = written
        self._differs_since_s: float | None = None

        # An asynchronous callback sees the value that the person chose, before anything else can change it.
        @handle.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client is not None:  # What the page itself sets is no wish.
                value = handle.value
                command(lambda: obey(value))

    def show(self, value: Any, now_s: float) -> None:
        """Take over what the session has, unless a wish for something else is younger than `WISH_S`."""
        value = self._written(value)
        if self._handle.value == value:
            self._differs_since_s = None
        elif self._differs_since_s is None:
            self._differs_since_s = now_s
        elif now_s - self._differs_since_s > WISH_S:
            self._handle.value = value  # type: ignore[misc]
            self._differs_since_s = None


def in_words(name: str) -> str:
    """The name of a behaviour as a person reads it."""
    return name.replace("_", " ")


def _hint(tool: str) -> str:
    return f'<div style="{PADDING};font-size:13px;line-height:1.35;color:#7cc8ff">{HINT[tool]}</div>'


def _small(text: str) -> str:
    return f'<div style="{PADDING};font-size:12.5px;line-height:1.35">{escape(text)}</div>'


def _sentence(meaning: str) -> str:
    """What a behaviour means as a sentence: of the robot, unless it names its own subject."""
    return f"{meaning[0].upper()}{meaning[1:]}." if meaning.startswith("its ") else f"The robot {meaning}."
