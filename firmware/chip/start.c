/* SPDX-License-Identifier: Apache-2.0
 * The first instructions after a reset, and the table of vectors that a Cortex-M finds at the start of its flash. */
#include <stdint.h>

extern uint32_t rs_stack_end, rs_data_start, rs_data_end, rs_data_image, rs_bss_start, rs_bss_end;
int main(void);
void rs_reset(void);
void rs_fault(void);

/* Interrupts of a board are declared here, weak, so that its port may define those it uses. */
void rs_interrupt(void) __attribute__((weak, alias("rs_fault")));

void rs_fault(void) {
  for (;;) {
    __asm__ volatile(
        "bkpt 0"); /* a debugger looks here; without one the core locks up, and a watchdog starts it anew */
  }
}

void rs_reset(void) {
  const uint32_t* from = &rs_data_image;
  for (uint32_t* to = &rs_data_start; to < &rs_data_end;) *to++ = *from++;
  for (uint32_t* to = &rs_bss_start; to < &rs_bss_end;) *to++ = 0;
  main();
  rs_fault();
}

typedef void (*vector)(void);

enum { SYSTEM_VECTORS = 16, INTERRUPTS = 32 };

__attribute__((section(".vectors"), used)) static const vector vectors[SYSTEM_VECTORS + INTERRUPTS] = {
    [0] = (vector)&rs_stack_end,
    [1] = rs_reset,
    [2 ... 15] = rs_fault,
    [16 ... SYSTEM_VECTORS + INTERRUPTS - 1] = rs_interrupt};
