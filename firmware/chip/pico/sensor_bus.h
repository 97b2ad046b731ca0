/* SPDX-License-Identifier: Apache-2.0
 * Readings of all sensors without waiting for any: I2C by interrupts, the analogue inputs by direct memory access. */
#ifndef ROBOTSKIN_SENSOR_BUS_H
#define ROBOTSKIN_SENSOR_BUS_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/channels.h"
#include "robotskin/portable.h"

void sensor_bus_start(void);

/* What an interrupt of I2C0 does. */
void sensor_bus_interrupt(void);

/* The newest readings, and lets the next ones be taken; true: a part is missing or at the end of its range. */
bool sensor_bus_read(rs_sample* sample);

#endif
