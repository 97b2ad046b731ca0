/* SPDX-License-Identifier: Apache-2.0
 * The cell's image in flash. To erase takes longer than a cell may be silent, so images are appended, and sectors are
 * erased at the start. */
#ifndef ROBOTSKIN_KEPT_IMAGES_H
#define ROBOTSKIN_KEPT_IMAGES_H

#include <stdint.h>

/* The newest image, or NULL; to be asked once, before anything else needs its time. */
const uint8_t* kept_image(void);

/* Appends RS_FLASH_BYTES. */
void keep_image(const uint8_t* image);

#endif
