# SPDX-License-Identifier: Apache-2.0
"""The sketch of the motors' microcontroller, compiled for this machine: what it takes, and when it falls silent."""

import shutil
import subprocess
from pathlib import Path

import pytest

SKETCH = Path(__file__).parents[3] / "examples" / "feet_motors" / "feet_motors.ino"
# A board whose clock and line are words on standard input: `at MS TEXT`; it prints the duties after each.
BOARD = r"""
#include <cstdio>
#include <iostream>
#include <string>
static unsigned long now_ms;
static int duties[16];
static std::string received;
enum { OUTPUT };
static unsigned long millis() { return now_ms; }
static void pinMode(int, int) {}
static void analogWrite(int pin, int duty) { duties[pin] = duty; }
struct {
  void begin(long) {}
  int available() { return static_cast<int>(received.size()); }
  int read() { int byte = received[0]; received.erase(0, 1); return byte; }
} Serial;
#include SKETCH
int main() {
  setup();
  std::string text;
  while (std::cin >> now_ms && std::getline(std::cin, text)) {
    for (std::size_t at = 1; at < text.size(); ++at) received += text[at] == '|' ? '\n' : text[at];
    loop();
    std::printf("%d %d %d\n", duties[9], duties[10], duties[11]);
  }
}
"""


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sketch as a program."""
    compiler = shutil.which("c++")
    assert compiler, "the project is built with one"
    room = tmp_path_factory.mktemp("board")
    (room / "board.cpp").write_text(BOARD)
    flags = ["-std=c++17", "-Wall", "-Wextra", "-Werror", "-fsanitize=address,undefined", f'-DSKETCH="{SKETCH}"']
    subprocess.run([compiler, *flags, "board.cpp", "-o", "board"], cwd=room, check=True)
    return room / "board"


def duties(board: Path, *moments: str) -> list[str]:
    """Of the motors after each moment."""
    said = subprocess.run([board], input="\n".join(moments), capture_output=True, text=True, check=True)
    return said.stdout.splitlines()


def test_lines_drive_the_motors_also_in_parts(board: Path) -> None:
    assert duties(board, "10 V 0 128 255|", "30 V 1 2", "31  3|V 4 5 6|") == ["0 128 255", "0 128 255", "4 5 6"]


@pytest.mark.parametrize(
    "wrong", ["V 1 2|", "V 1 2 3 4|", "V 1 2 256|", "V -1 2 3|", "X 1 2 3|", "|", f"V 1 2 3{'4' * 60}|", "\x00\x7f|"]
)
def test_a_line_that_is_none_moves_nothing_and_the_next_is_taken(board: Path, wrong: str) -> None:
    assert duties(board, "10 V 7 8 9|", f"20 {wrong}", "30 V 1 2 3|") == ["7 8 9", "7 8 9", "1 2 3"]


def test_a_silent_line_stops_the_motors_within_100_ms(board: Path) -> None:
    kept = duties(board, "1000 V 7 8 9|", "1080 ", "1100 ", "1120 V 1 1 1|", "1200 nonsense|", "1220 more|")
    assert kept == ["7 8 9", "7 8 9", "0 0 0", "1 1 1", "1 1 1", "0 0 0"]
