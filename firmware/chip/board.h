/* SPDX-License-Identifier: Apache-2.0
 * What the firmware needs of the board that carries it: twelve functions. To port the cell, write these.
 *
 * Interrupts only collect: bytes that arrive, frames that are out, alarms that ring. main.c asks for them between two
 * steps, so that no function here is called from an interrupt and the cell's state needs no lock. */
#ifndef ROBOTSKIN_BOARD_H
#define ROBOTSKIN_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/cell.h"

/* Clocks, four serial lines at 4 Mb/s 8N1, timer, sensors. Fills what the cell boots with: its serial number, a number
 * that is another at each boot, and where flash image and keys are, NULL for none. */
void rs_board_start(rs_boot* boot);

/* Microseconds since any moment, wrapping at 2^32. */
uint32_t rs_board_now_us(void);

/* ---- What has happened ---- */

enum {
  RS_BOARD_LINE = 1 << 0,  /* bit p - 1: bytes have come on port p */
  RS_BOARD_SENT = 1 << 4,  /* bit 4 + p - 1: the frame on port p is out, and something waits for that; rs_board_sent
                              tells which, once: main.c may have asked before it comes to this event */
  RS_BOARD_TIMER = 1 << 8, /* the time of rs_board_alarms has come */
  RS_BOARD_SAMPLE = 1 << 9
};

/* When to wake next. `sampling`: sample_us counts. `wanted`, bit p - 1: so does the end of the frame on port p. */
void rs_board_alarms(uint32_t timer_us, bool sampling, uint32_t sample_us, uint32_t wanted);

/* Another `wanted`; the alarms stay as they are. */
void rs_board_wanted(uint32_t wanted);

/* Sleeps until one of these has happened at least, and forgets what it returns. */
uint32_t rs_board_wait(void);

/* ---- Lines ---- */

/* Bytes of a port (0 to 3) that have come: how many stand together at `bytes`, which stay until this is asked again,
 * and whether the line was idle for two byte times before the first of them. What does not stand together with them is
 * told by another RS_BOARD_LINE: a board that receives by direct memory access hands out its ring in one or two pieces.
 */
uint32_t rs_board_receive(unsigned port, const uint8_t** bytes, bool* idle);

/* Starts to send RS_FRAME_BYTES, which stay where they are until the frame is out; they begin at a whole word. */
void rs_board_send(unsigned port, const uint8_t* frame);

/* Bit p - 1: the frame on port p has gone out since this was last asked. */
uint32_t rs_board_sent(void);

/* ---- Sensors, light, memory ---- */

/* The nine channels, in counts; true if a sensor is missing or at the end of its range. */
bool rs_board_sense(rs_sample* sample);

void rs_board_light(uint32_t rgb);

/* Writes RS_FLASH_BYTES to where the next boot finds them. */
void rs_board_keep(const uint8_t* flash);

/* Starts the chip anew. */
void rs_board_restart(void);

#endif
