# SPDX-License-Identifier: Apache-2.0
"""`--threads` of what runs a whole robot reaches the network of its skin, and changes nothing of the run."""

import pytest
from typer.testing import CliRunner

from robotskin import session as sessions
from robotskin.cli import demo, main
from robotskin.cli import run as run_verb
from robotskin.session import PERIOD_S, Session
from robotskin.session import session as session_module

PUSH_N, RUNS_S = 8.0, 0.1
VERBS = {"run": (run_verb, ["run", "dual_arm"]), "demo": (demo, ["demo", "--robot", "dual_arm"])}


@pytest.mark.parametrize("verb", VERBS)
def test_the_threads_that_are_asked_for_make_the_same_run(
    verb: str, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    module, words = VERBS[verb]
    asked: list[int] = []
    found: list[tuple[int, bytes]] = []

    class Kept(Session):
        """Without sockets, so that keys come from the seed."""

        def __init__(self, *arguments: object, threads: int = 1, **options: object) -> None:
            asked.append(threads)
            super().__init__(*arguments, **options, threads=threads, link="in process")  # type: ignore[arg-type]

    def short(session: Session, *_: object) -> int:
        try:
            session.boot()
            session.world.push(session.in_world(0), PUSH_N)
            for _ in range(round(RUNS_S / PERIOD_S)):
                session.step()
            assert session.world.network.lane_count == 2, "two groups share no wire"
            found.append((session.world.network.log_hash, session.joints.position.tobytes()))
        finally:
            session.shut_down()
        return 0

    monkeypatch.setattr(sessions, "Session", Kept)
    monkeypatch.setattr(module, "run_script", short)
    for options in ([], ["--threads", "2"]):
        answer = CliRunner().invoke(main.app, [*words, "--headless", "--seed", str(seed), *options])
        assert answer.exit_code == 0, answer.output
    assert asked == [1, 2]
    assert found[0] == found[1]


APPS = (["balance"], ["balance", "--soles"], ["embrace"], ["embrace", "--grasp"])


@pytest.mark.parametrize("words", APPS, ids=" ".join)
def test_the_world_of_an_application_has_the_threads_that_are_asked_for(
    words: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    class Asked(Exception):
        """Instead of a world."""

    def world(*_: object, threads: int, **__: object) -> None:
        raise Asked(threads)

    monkeypatch.setattr(session_module, "World", world)
    answer = CliRunner().invoke(main.app, ["app", *words, "--headless", "--threads", "3"])
    assert isinstance(answer.exception, Asked), answer.output
    assert answer.exception.args == (3,)


def test_threads_are_refused_where_arms_are_led() -> None:
    answer = CliRunner().invoke(main.app, ["app", "embrace", "--teach", "path.toml", "--headless", "--threads", "2"])
    assert answer.exit_code == 2
    assert "--threads" in answer.output
