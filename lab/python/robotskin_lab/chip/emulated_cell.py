# SPDX-License-Identifier: Apache-2.0
"""A cell on an emulated chip: the cross-built firmware in the Unicorn emulator, on the board of emulated_board.c."""

from __future__ import annotations

import struct
from collections.abc import Callable

from robotskin import firmware
from robotskin_lab.chip.errors import ChipError
from robotskin_lab.chip.image import FLASH_BYTES, FLASH_START, RAM_BYTES, RAM_START, ChipImage

try:
    import unicorn
    from unicorn import arm_const
except ImportError:  # without the extra there is a bench all the same, but no chip
    unicorn = None  # type: ignore[assignment]

BOOT, FRAME, SENT, SAMPLE, TIMER = range(5)
"""Kinds of input, as of rs_input_kind."""
_INPUTS = ("boot", "frame", "sent", "sample", "timer")
_FRAMES = {number: name for name, number, _ in firmware.FRAME_TYPES}

_INWARD, _OUTWARD, _PAGE = 0x40000000, 0x40001000, 0x1000
_UID, _FAULT, _CHANNELS, _COUNT, _IDLE, _BYTES = 12, 28, 32, 68, 84, 88
_KEY = _BYTES + firmware.PORTS * firmware.FRAME_BYTES
_STEP = _KEY + 2 * firmware.CELL_KEY_BYTES
_LATE = _STEP + 4
_OUTWARD_WORDS = 13
_TIMER_EVENT, _SAMPLE_EVENT = 1 << 8, 1 << 9
_PAINT = 0xA5

Answer = tuple[tuple[bytes | None, ...], int, int | None, int, int | None, bytes | None, bool]


class EmulatedCell:
    """One cell; a call is one input of the cell (cell.h) turned into what its board would tell it.

    A call answers what a `robotskin.simulator.ExternalCell` has to. Raises ChipError without the emulator.
    """

    def __init__(self, image: ChipImage) -> None:
        if unicorn is None:
            raise ChipError("the emulator is missing: `make build` installs it")
        self.image = image
        self.machine = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
        self.machine.ctl_set_cpu_model(arm_const.UC_CPU_ARM_CORTEX_M0)
        self.machine.mem_map(FLASH_START, FLASH_BYTES, unicorn.UC_PROT_READ | unicorn.UC_PROT_EXEC)
        self.machine.mem_map(RAM_START, RAM_BYTES, unicorn.UC_PROT_ALL)
        self.machine.mem_map(_INWARD, 2 * _PAGE, unicorn.UC_PROT_READ | unicorn.UC_PROT_WRITE)
        self.machine.mem_write(FLASH_START, image.flash)
        self._asleep = image.symbols["rs_board_asleep"] & ~1
        self._fault = image.symbols["rs_fault"] & ~1
        self._stack_deepest = 0
        self.around: Callable[[Callable[[], None]], None] = lambda run: run()
        """Is given what runs the chip until it sleeps again, to be called once: where a meter looks on."""
        self.input = "boot"
        """What the input being carried out is: a frame's type, or boot, sent, sample, timer."""

    # ---- What the chip is told ----

    def __call__(self, kind: int, port: int, sent: int, fault: bool, content: object, now_us: int) -> Answer:
        """Carry out one input of the cell and answer what the chip asks of its board."""
        events = 0
        self.input = _INPUTS[kind]
        if kind == BOOT:
            assert isinstance(content, tuple)
            self._power_up(*content)
        elif kind == FRAME:
            assert isinstance(content, tuple)
            frame, late_us = content
            self.input = _FRAMES.get(frame[0] >> 4, self.input)
            self._put_on_line(port - 1, frame, late_us)
            events = 1 << (port - 1)
        elif kind == SENT:
            events = 1 << (4 + port - 1)
            sent |= 1 << (port - 1)
        elif kind == SAMPLE:
            assert isinstance(content, bytes)
            self.machine.mem_write(_INWARD + _FAULT, struct.pack("<I", fault) + content)
            events = _SAMPLE_EVENT
        else:
            events = _TIMER_EVENT
        self.machine.mem_write(_INWARD, struct.pack("<III", events, now_us, sent))
        begin = self.image.symbols["rs_reset"] if kind == BOOT else self._asleep + 2
        self.around(lambda: self._run(begin | 1))
        return self._answer()

    def _power_up(self, uid: int, random: int, flash: bytes | None, key: bytes | None, step_us: int) -> None:
        self._note_stack()
        self.machine.mem_write(RAM_START, bytes([_PAINT]) * RAM_BYTES)
        self.machine.mem_write(_INWARD, bytes(2 * _PAGE))
        kept = self.image.symbols["rs_kept_start"]
        self.machine.mem_write(kept, (flash or b"").ljust(FLASH_BYTES - kept, b"\xff"))
        boot = struct.pack("<IIII", uid, random, flash is not None, key is not None)
        self.machine.mem_write(_INWARD + _UID, boot)
        self.machine.mem_write(_INWARD + _KEY, key or b"")
        self.machine.mem_write(_INWARD + _STEP, struct.pack("<I", step_us))
        (stack,) = struct.unpack_from("<I", self.image.flash)
        self.machine.reg_write(arm_const.UC_ARM_REG_SP, stack)

    def _put_on_line(self, port: int, frame: bytes, late_us: int) -> None:
        """A frame after an idle line: the simulated links carry whole frames."""
        self.machine.mem_write(_INWARD + _BYTES + firmware.FRAME_BYTES * port, frame)
        self.machine.mem_write(_INWARD + _IDLE, (1 << port).to_bytes(4, "little"))
        self.machine.mem_write(_INWARD + _COUNT + 4 * port, len(frame).to_bytes(4, "little"))
        self.machine.mem_write(_INWARD + _LATE, late_us.to_bytes(4, "little"))

    def _run(self, begin: int) -> None:
        try:
            self.machine.emu_start(begin, self._asleep)
        except unicorn.UcError as error:
            at = self.machine.reg_read(arm_const.UC_ARM_REG_PC)
            raise ChipError(f"the chip faults at 0x{at:x}: {error}") from error
        at = self.machine.reg_read(arm_const.UC_ARM_REG_PC) & ~1
        if at != self._asleep:
            raise ChipError(f"the chip stopped at 0x{at:x} instead of going to sleep")

    # ---- What the chip asks for ----

    def _answer(self) -> Answer:
        words = struct.unpack(f"<{_OUTWARD_WORDS}I", self.machine.mem_read(_OUTWARD, 4 * _OUTWARD_WORDS))
        timer_us, sampling, sample_us, wanted, started = words[:5]
        light, lit, keep, restart = words[9:13]
        frames: tuple[bytes | None, ...] = (None,) * firmware.PORTS
        if started:
            frames = tuple(
                bytes(self.machine.mem_read(words[5 + port], firmware.FRAME_BYTES)) if started >> port & 1 else None
                for port in range(firmware.PORTS)
            )
        kept = bytes(self.machine.mem_read(keep, firmware.FLASH_BYTES)) if keep else None
        if started or lit or keep or restart:
            self.machine.mem_write(_OUTWARD + 16, bytes(4 * (_OUTWARD_WORDS - 4)))
        if kept is not None:
            self.machine.mem_write(self.image.symbols["rs_kept_start"], kept)
        return frames, timer_us, sample_us if sampling else None, wanted, light if lit else None, kept, bool(restart)

    # ---- What it has used ----

    def _note_stack(self) -> None:
        free = bytes(self.machine.mem_read(RAM_START, RAM_BYTES))[self.image.static_bytes :]
        untouched = len(free) - len(free.lstrip(bytes([_PAINT])))
        if any(free):
            self._stack_deepest = max(self._stack_deepest, len(free) - untouched)

    @property
    def stack_bytes(self) -> int:
        """The deepest the stack has been since this object was made: bytes of RAM that are not as painted at boot."""
        self._note_stack()
        return self._stack_deepest

    @property
    def ram_bytes(self) -> int:
        """Variables and the deepest stack."""
        return self.image.static_bytes + self.stack_bytes
