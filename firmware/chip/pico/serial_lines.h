/* SPDX-License-Identifier: Apache-2.0
 * Four serial lines at 4 Mb/s of the RP2040: eight PIO state machines, whose bytes go by direct memory access into
 * blocks of a frame. */
#ifndef ROBOTSKIN_SERIAL_LINES_H
#define ROBOTSKIN_SERIAL_LINES_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/portable.h"

void serial_lines_start(void);

/* What interrupt `number` of DMA or PIO does. */
void serial_lines_interrupt(uint32_t number);

/* Bit p: blocks have come on port p that were not taken; the frame on port p is out. */
uint32_t serial_lines_come(void);
uint32_t serial_lines_gone(void);
uint32_t serial_lines_take_gone(void); /* once */

/* As rs_board_receive and rs_board_send. */
uint32_t serial_lines_receive(unsigned port, const uint8_t** bytes, bool* idle);
void serial_lines_send(unsigned port, const uint8_t* frame);
uint32_t serial_lines_came_us(unsigned port); /* when the block that was received last was whole, by the timer */

#endif
