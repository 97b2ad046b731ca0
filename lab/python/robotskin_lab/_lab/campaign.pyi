"""Random skins and faults under checkers of the network's laws."""

from collections.abc import Sequence

class Break:
    """One invariant broken at one time."""

    @property
    def invariant(self) -> str: ...
    @property
    def number(self) -> int:
        """as in I1 to I19"""

    @property
    def time_ns(self) -> int:
        """virtual"""

    @property
    def cells(self) -> list[int]:
        """concerned"""

    @property
    def values(self) -> list[tuple[str, int]]: ...
    def __str__(self) -> str: ...

class FaultCase:
    """A skin, its section units, lines and clocks, and what strikes it when."""

    @property
    def seed(self) -> int: ...
    @property
    def shape(self) -> str: ...
    @property
    def cells(self) -> int: ...
    @property
    def section_units(self) -> int: ...
    @property
    def ports(self) -> int:
        """cables plugged in"""

    @property
    def keyed(self) -> bool:
        """ticks and commands are authenticated"""

    @property
    def whole_lines(self) -> bool:
        """no frame is lost or damaged by chance"""

    @property
    def while_forming(self) -> bool:
        """faults begin before the network has formed"""

    @property
    def events(self) -> bool:
        """cells send what changes, not every sample"""

    @property
    def touched_percent(self) -> int:
        """of the cells at a time, where they send what changes"""

    @property
    def events_hz(self) -> int:
        """so often they look for a change"""

    @property
    def limbs(self) -> int:
        """whose torques are summed; 0: none"""

    @property
    def orders(self) -> bool:
        """the host sends commands and joints"""

    @property
    def touch(self) -> bool:
        """cells compute their own torques"""

    @property
    def duration_ns(self) -> int: ...
    @property
    def text(self) -> str:
        """All of it, many lines; `parse_case` reads it."""

    @property
    def after_ns(self) -> int:
        """from the last effect of the last fault to the end"""

    @property
    def faults(self) -> list[str]: ...
    def __str__(self) -> str: ...

class CaseReport:
    """What the checkers found in one case."""

    @property
    def seed(self) -> int: ...
    @property
    def breaks(self) -> list[Break]:
        """of each invariant the first few"""

    @property
    def break_count(self) -> int:
        """all"""

    @property
    def log_hash(self) -> int:
        """of every frame and datagram: equal for equal runs"""

    @property
    def events(self) -> int: ...
    @property
    def samples_taken(self) -> int: ...
    @property
    def samples_delivered(self) -> int: ...
    @property
    def events_repeated(self) -> int:
        """sent again, and marked so"""

    @property
    def crowded_out_most(self) -> int:
        """samples that found no room after one fault, in trees within load"""

    @property
    def lost_overloaded(self) -> int:
        """samples that were lost in trees that had more than their cables carry"""

    @property
    def excused(self) -> int:
        """samples that were false after memory was damaged"""

    @property
    def torque_sums(self) -> int:
        """at the host"""

    @property
    def torque_epochs(self) -> int:
        """that had to be complete"""

    @property
    def frames_planted(self) -> int:
        """forged, or played again"""

    @property
    def simulated_s(self) -> float: ...
    @property
    def longest_repair_ms(self) -> float:
        """flapping and hold-down included"""

    @property
    def longest_wait_ms(self) -> float:
        """of a sample in a cell, in whole networks"""

    @property
    def largest_control_share(self) -> float:
        """of a wire"""

def draw_case(seed: int, ideal_processors: bool = False) -> FaultCase:
    """
    The case of a seed. Processors have 48 MHz and one flash wait state; ideal_processors: they take no time.
    """

def parse_case(text: str) -> FaultCase:
    """
    The case that `FaultCase.text` tells. Raises ValueError, which names what cannot be read.
    """

def run_case(case: FaultCase) -> CaseReport:
    """Run it under all checkers."""

def shrink(case: FaultCase, invariant: str, runs_max: int = 200) -> FaultCase:
    """
    A smaller case that breaks the same invariant: without faults, then without cells. Raises ValueError for an unknown name.
    """

def invariants() -> list[tuple[str, int, str]]:
    """(name, number, what must be true) of each."""

class ModelOptions:
    """A small network, and how far its states are explored."""

    def __init__(self) -> None: ...
    @property
    def cells(self) -> int:
        """1 to 5"""

    @cells.setter
    def cells(self, arg: int, /) -> None: ...
    @property
    def linked(self) -> list[int]:
        """bit j of linked[i]: a wire joins cells i and j"""

    @linked.setter
    def linked(self, arg: Sequence[int], /) -> None: ...
    @property
    def roots(self) -> int:
        """bit i: cell i has a section unit's port"""

    @roots.setter
    def roots(self, arg: int, /) -> None: ...
    @property
    def sequences(self) -> int:
        """ticks, 1 to 3"""

    @sequences.setter
    def sequences(self, arg: int, /) -> None: ...
    @property
    def boots(self) -> int:
        """reboots in a run, at most"""

    @boots.setter
    def boots(self, arg: int, /) -> None: ...
    @property
    def quarantine(self) -> bool: ...
    @quarantine.setter
    def quarantine(self, arg: bool, /) -> None: ...
    @property
    def states_max(self) -> int: ...
    @states_max.setter
    def states_max(self, arg: int, /) -> None: ...

class ModelReport:
    """What the exploration found."""

    @property
    def states(self) -> int:
        """explored, up to the symmetries of the graph"""

    @property
    def transitions(self) -> int: ...
    @property
    def exhausted(self) -> bool:
        """nothing is left to explore"""

    @property
    def loop(self) -> bool: ...
    @property
    def trace(self) -> list[str]:
        """the shortest way to the loop, a step a line"""

def check_model(options: ModelOptions) -> ModelReport:
    """
    Explore every state under the firmware's parent rule. Raises ValueError for options out of range.
    """

def largest_graphs(cells: int) -> list[ModelOptions]:
    """
    The graphs on so many cells to which no wire can be added; all others are parts of them.
    """
