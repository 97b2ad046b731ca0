# SPDX-License-Identifier: Apache-2.0
"""The code speaks as docs/glossary.md says: each of its terms is in use, and the words they replaced are gone."""

import re
from pathlib import Path

import pytest

from tracked_files import ROOT, tracked_files

PAGE = ROOT / "docs/glossary.md"
ROWS = re.findall(r"^\| ([^|]+) \| [^|]+ \| ([^|]+) \| [^|]+ \|$", PAGE.read_text(), re.MULTILINE)
TERMS = [row for row in ROWS if row[0] != "term"]

# What was said before, as identifiers or as words of identifiers, and what is said now.
RETIRED = {
    r"\bsection_unit\s*=[^=]|[.>]section_unit\b": "group",
    r"\brs_frame_\w*replayed": "retransmitted",
    r"\bSkinTask\b": "TouchWrench",
    r"\b(rs_|takes?_)?own_torques?\b": "cell_torque, skin_computed_torque",
    r"\b[Tt]wins?(Output)?\b": "duplicate_id, ExternalCell",
    r"\bhold_(whole|size)\b|[.>]hold_us\b|\bheld_until_us\b": "handover, hold_down",
    r"rs_(retention|retained|hearing)|RS_RETENTION|\bretention\b": "arq_sender, arq_receiver",
    r"\badvert(s|ise|ised|_\w+)?\b": "beacon",
    r"spoilt|SPOILT": "lossy",
    r"rs_wants|rs_want_|\bwant_\d_": "demands",
    r"\byielding\b": "draining_ticks",
    r"rs_queues_(crowd|calm)": "throttle, relax",
    r"RS_APART": "RS_NOINLINE",
    r"\bStranger\b|\bstrangers_": "PendingUnit",
    r"\b(unprojected|UNPROJECTED)\b": "feedforward",
    r"\b(Warmth|Reflection)\b": "Temperature, Proximity",
    r"\bLetter\b|\bhaunt\b|Network::Act\b": "InFlightDatagram, run_zombie, RunningFault",
    r"\b[Rr]eferee\b|\bGround\b(?! truth)": "Checkers, GroundTruth",
    r"\bbelieved=": "estimated_layout",
    r"\bFound(Cell|Skin)\b": "RawCell, RawLayout",
}

# Where files with old words are read, this list, and where the changelog tells of the change.
MAY_SAY_OLD_WORDS = {
    "core/world/network/fault_text.cpp",
    "python/robotskin/layout/old_words.py",
    "tests/python/layout/test_old_words.py",
    "tests/test_words.py",
    "CHANGELOG.md",
    "tests/python/sharing/foxglove_client.py",  # "advertise" is a word of the protocol
    "tests/python/foreign/test_ros2_skin.py",  # "advertise" is a word of rosless
    "tests/python/sharing/test_ros2_commands.py",  # and a method of rosless
    "tests/python/ros2/test_joints_port.py",  # the same
}


def sources() -> list[Path]:
    return tracked_files(".c", ".h", ".cpp", ".hpp", ".py", ".pyi", ".cmake", ".toml")


def old_words_in(text: str) -> list[str]:
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        found += [f"line {number}: say {new}: {line.strip()}" for old, new in RETIRED.items() if re.search(old, line)]
    return found


def test_the_glossary_has_terms() -> None:
    assert len(TERMS) > 35
    assert len({term for term, _ in TERMS}) == len(TERMS), "a term stands once"


@pytest.fixture(scope="module")
def code() -> str:
    return "\n".join(path.read_text() for path in sources() if path.name != Path(__file__).name)


@pytest.mark.parametrize(("term", "where"), TERMS, ids=lambda value: value.strip("`")[:20])
def test_a_term_of_the_glossary_is_in_use(term: str, where: str, code: str) -> None:
    for place in re.findall(r"`([^`]+)`", where):
        if "/" in place:
            assert (ROOT / place).exists(), f"{term}: {place} is not there"
        else:
            assert re.search(rf"\b{re.escape(re.split(r'[.:]+', place)[-1])}\b", code), f"{term}: {place} is not in use"


def test_retired_words_occur_nowhere() -> None:
    found = []
    for path in [*sources(), *tracked_files(".md")]:
        name = path.relative_to(ROOT).as_posix()
        if name not in MAY_SAY_OLD_WORDS:
            found += [f"{name}: {what}" for what in old_words_in(path.read_text())]
    assert not found, "\n".join(found)


def test_a_retired_word_is_seen() -> None:
    assert old_words_in("  layout.section_unit[3]")
    assert old_words_in("the advert of a twin")
    assert not old_words_in("the beacon of a section unit")


PEOPLE = re.compile(r"(?<![a-z])(who|whom|whoever|nobody|anybody|somebody|everybody|someone)(?![a-z])", re.IGNORECASE)
ABOUT_PEOPLE = re.compile(r"\b(those|people|Those|People) who\b")  # users and attackers
MAY_SPEAK_OF_PEOPLE = {"tests/test_words.py"}


def speaks_of_people(line: str) -> bool:
    """Whether cells, units and programs are spoken of as of people: who they are, and nobody."""
    return PEOPLE.search(ABOUT_PEOPLE.sub("", line)) is not None


def test_cells_and_machines_are_not_people() -> None:
    """A cell is a cell: which it is, and none, not who it is, and nobody."""
    found = []
    for path in [*sources(), *tracked_files(".md", ".json")]:
        name = path.relative_to(ROOT).as_posix()
        if name not in MAY_SPEAK_OF_PEOPLE:
            lines = enumerate(path.read_text().splitlines(), 1)
            found += [f"{name}:{number}: {line.strip()[:200]}" for number, line in lines if speaks_of_people(line)]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    "line", ["cells who have no parent", "GroundTruth::nobody", "def test_a_grant_moves_nobody():"]
)
def test_a_cell_as_a_person_is_seen(line: str) -> None:
    assert speaks_of_people(line)
    assert not speaks_of_people("it yields to those who push")
    assert not speaks_of_people("the whole of it")
