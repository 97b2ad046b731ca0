"""The datagrams of section units, without simulating cells."""

import numpy

class Traffic:
    """
    The datagrams of section units with many cells in clock mode, without simulating cells.
    """

    def __init__(
        self,
        cells: int = 1260,
        *,
        rate_hz: int = 250,
        key: bytes | None = None,
        records_per_datagram: int = 71,
        seed: int = 1,
        event_mode: bool = False,
    ) -> None: ...
    def keys(self) -> list[int]: ...
    def hear(self, arg: bytes, /) -> None: ...
    @property
    def frames(self) -> int:
        """Frames sent so far."""

    @property
    def connected(self) -> bool:
        """Whether every unit has a host and knows that it lives now."""

    def step(self, now_ns: int) -> list[bytes]:
        """
        The datagrams of the millisecond that ends at `now_ns` of the section units' clock.
        """

    def flush(self, now_ns: int) -> list[bytes]:
        """The datagrams of what still waits for its datagram to fill."""

    def sent(self) -> dict[str, numpy.ndarray]:
        """The last frame of each cell, sent or waiting, in counts."""

def send_traffic(
    to: tuple[str, int],
    local: tuple[str, int],
    seconds: float,
    *,
    cells: int = 1260,
    rate_hz: int = 250,
    key: bytes | None = None,
    records_per_datagram: int = 69,
    seed: int = 1,
    patience_s: float = 10.0,
    realtime: bool = False,
    prepared: bool = False,
) -> dict[str, float]:
    """
    Sends traffic over UDP in steps of a millisecond, as soon as a host listens; what was sent.
    `prepared`: all of it is made and tagged before the first datagram leaves.
    Raises RuntimeError if no host sends a keep-alive within `patience_s`.
    """
