/* SPDX-License-Identifier: Apache-2.0
 * The cell's keys in a sector of their own: with the image, or written once over a line. */
#ifndef ROBOTSKIN_KEPT_KEYS_H
#define ROBOTSKIN_KEPT_KEYS_H

#include <stdint.h>

/* RS_CELL_KEYS_BYTES, or NULL: it has none. */
const uint8_t* kept_keys(void);

/* Erases them. A person asks for that, by a wire at the board. */
void forget_keys(void);

/* Waits until the cell with serial number `uid` has been given keys over a line, and writes them. */
void take_keys(uint32_t uid);

#endif
