/* SPDX-License-Identifier: Apache-2.0
 * The first 252 bytes of the flash, which the chip's ROM copies to RAM and runs: they let the flash be read by its
 * plain serial command 03h, which every flash has, and jump to the program. Their checksum is added to the image. */

__attribute__((naked, used, section(".boot2"))) void rs_boot2(void);
__attribute__((naked, used, section(".boot2"))) void rs_boot2(void) {
  __asm__ volatile(
      "ldr r0, 5f\n"
      "movs r1, #0\n str r1, [r0, #0x08]\n" /* off */
      "movs r1, #4\n str r1, [r0, #0x14]\n" /* a fourth of the clock */
      "ldr r1, 1f\n str r1, [r0, #0x00]\n"
      "ldr r1, 2f\n ldr r2, 3f\n str r1, [r2]\n"
      "movs r1, #0\n str r1, [r0, #0x04]\n"
      "movs r1, #1\n str r1, [r0, #0x08]\n"
      "ldr r0, 4f\n mov sp, r0\n"
      "ldr r0, 6f\n bx r0\n"
      ".align 2\n"
      "5: .word 0x18000000\n" /* the serial interface of the flash */
      "1: .word 0x001F0300\n" /* words of 32 bits, as an EEPROM is read */
      "2: .word 0x03000218\n" /* command 03h, 8 bits of it, 24 of address */
      "3: .word 0x180000F4\n"
      "4: .word rs_stack_end\n"
      "6: .word rs_reset\n");
}
