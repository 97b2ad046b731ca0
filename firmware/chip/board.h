/* SPDX-License-Identifier: Apache-2.0
 * What the firmware needs of the board that carries it: thirteen functions. To port the cell, write these.
 *
 * Interrupts only collect: bytes that arrive, frames that are out, alarms that ring. main.c asks for them between two
 * steps, so that no function here is called from an interrupt and the cell's state needs no lock. */
#ifndef ROBOTSKIN_BOARD_H
#define ROBOTSKIN_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/cell.h"

/* Clocks, four serial lines at 4 Mb/s 8N1, timer, sensors. Fills what the cell boots with: its serial number, a number
 * that is another at each boot, and where flash image and keys are, NULL for none. A board that was made without keys
 * waits here until it has been given some over a line (commissioning.h), and lets a person clear them. */
void rs_board_start(rs_boot* boot);

/* Microseconds since any moment, wrapping at 2^32. */
uint32_t rs_board_now_us(void);

/* ---- What has happened ---- */

enum {
  RS_BOARD_LINE = 1 << 0,  /* bit p - 1: bytes have come on port p */
  RS_BOARD_SENT = 1 << 4,  /* bit 4 + p - 1: port p takes another frame, and something waits for that; rs_board_sent
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

/* How long ago the last of the bytes of a port that rs_board_receive has handed out came; 0 where that is not known.
 * The group's time is told by ticks, and each hop would be late by the time that its ticks wait for the processor. */
uint32_t rs_board_late_us(unsigned port);

/* Sends RS_FRAME_BYTES, behind the frame that goes out if there is one. They begin at a whole word, and stay where they
 * are until RS_FRAMES_OUT - 1 others of that port have been given. */
void rs_board_send(unsigned port, const uint8_t* frame);

/* Bit p - 1: port p takes another frame since this was last asked. A board that lets none wait says so when its frame
 * is out; one that hands a frame after the other to direct memory access says so while fewer than RS_FRAMES_OUT are not
 * out. The line then stands still for none of the time that an input takes: 66 cells a cable at 250 Hz need that. */
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
