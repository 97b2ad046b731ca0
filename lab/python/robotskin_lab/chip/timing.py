# SPDX-License-Identifier: Apache-2.0
"""What an instruction takes on a Cortex-M0+, by the table of the core's technical reference manual (section 3.3)."""

from __future__ import annotations

from dataclasses import dataclass

from robotskin_lab.chip.image import FLASH_BYTES, FLASH_START

SLOW_MULTIPLIER_CYCLES = 32
"""Of the smaller of the two multipliers a chip may be made with; the other takes one."""


@dataclass(frozen=True)
class Cost:
    """Of a stretch of instructions without a jump in it, but perhaps at its end."""

    instructions: int
    cycles: int
    """With the fast multiplier and memory without wait states; a conditional jump at the end taken."""
    multiplications: int
    fall_through: int
    """Address behind the stretch if a conditional jump ends it, which saves a cycle when it is not taken; else -1."""
    fetches: int
    """Words of flash that hold it, none if it runs in RAM: each costs a cycle more with one wait state and no cache."""


def cost_of(code: bytes, address: int) -> Cost:
    """Of the instructions in `code`, which stands at `address`."""
    instructions = cycles = multiplications = 0
    fall_through = -1
    at = 0
    while at < len(code):
        half = int.from_bytes(code[at : at + 2], "little")
        wide = half >> 11 in (0b11101, 0b11110, 0b11111)
        cycles += 3 if wide else _cycles(half)  # BL, barriers, moves from and to special registers
        multiplications += half & 0xFFC0 == 0x4340
        at += 4 if wide else 2
        instructions += 1
        fall_through = address + at if _is_conditional_jump(half) else -1
    in_flash = address < FLASH_START + FLASH_BYTES
    words = (address + len(code) - 1) // 4 - address // 4 + 1 if in_flash else 0
    return Cost(instructions, cycles, multiplications, fall_through, words)


def _is_conditional_jump(half: int) -> bool:
    return half >> 12 == 0b1101 and (half >> 8) & 0xF < 14


def _cycles(half: int) -> int:
    """Of one 16-bit instruction, taken jumps; MULS with the fast multiplier."""
    top = half >> 12
    if half & 0xFF00 == 0x4700:  # BX, BLX
        return 2
    if half & 0xFC00 == 0x4400:  # ADD, CMP, MOV of high registers; into PC it is a jump
        writes_pc = half & 0x87 == 0x87 and half & 0x0300 != 0x0100
        return 2 if writes_pc else 1
    if half & 0xF800 == 0x4800 or top in (0b0101, 0b0110, 0b0111, 0b1000, 0b1001):  # loads and stores
        return 2
    if half & 0xFE00 == 0xB400:  # PUSH
        return 1 + (half & 0x1FF).bit_count()
    if half & 0xFE00 == 0xBC00:  # POP, into PC it is a jump
        return (3 if half & 0x100 else 1) + (half & 0x1FF).bit_count()
    if top == 0b1100:  # LDM, STM
        return 1 + (half & 0xFF).bit_count()
    if _is_conditional_jump(half) or half & 0xF800 == 0xE000:  # B
        return 2
    if half & 0xFFEF == 0xBF20:  # WFE, WFI
        return 2
    return 1
