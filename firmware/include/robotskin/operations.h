/* SPDX-License-Identifier: Apache-2.0
 * What commands ask of a cell, and how a cell answers.
 *
 * A command is addressed to one cell or to all; only a cell addressed by its own id answers with a `reply`, except that
 * all cells answer `ping` and `topology`. A cell carries out each counter once and repeats its last reply if the same
 * command comes again. Section units send `assign` and `rejoin` themselves, uncounted: the one is made fresh by its
 * challenge, the other does nothing once the cell has given up the id it names. */
#ifndef ROBOTSKIN_OPERATIONS_H
#define ROBOTSKIN_OPERATIONS_H

#include "robotskin/wire.h"

// clang-format off
/* X(name, number, index, value) */
#define RS_OPERATIONS(X)                                                                                     \
  X(assign, 1, "new id", "low: uid of the cell; high: challenge of its join frame")                          \
  X(ping, 2, "echoed", "answer: tick number at the cell")                                                    \
  X(topology, 3, "0", "answer: a topology frame")                                                            \
  X(clock_rate, 4, "0", "samples per second in clock mode: 0, 63, 125 or 250")                               \
  X(mode, 5, "0", "0: clock mode, 1: event mode")                                                            \
  X(event_rate, 6, "0", "samples per second in event mode: 8 to 1000")                                       \
  X(threshold, 7, "channel 0 to 8", "counts, 1 to 65535: change that makes an event")                        \
  X(event_mask, 8, "0", "bit c: channel c makes events")                                                     \
  X(offset, 9, "channel 0 to 8", "counts, signed: added to each reading")                                    \
  X(led, 10, "0", "colour 0xRRGGBB")                                                                         \
  X(store, 11, "0", "keeps id and settings in flash")                                                        \
  X(forget, 12, "0", "erases id and settings from flash; those in force stay until the next boot")           \
  X(read, 13, "index of the setting", "low: number of its operation; answer: high: that number, low: value in force") \
  X(rejoin, 14, "id to give up", "low: uid of the cell, which has to ask for another id")                    \
  X(torque_word, 15, "word 0 to 50", "high, low: six bytes of the torque parameters (torque_parameters.h), of which there are none until the next torque_commit") \
  X(torque_commit, 16, "0", "checksum of the torque parameters written: they come into force, and into flash; read: that checksum, or 65536 for none in force")

/* X(name, number, meaning) */
#define RS_REPLY_STATUSES(X)                            \
  X(done, 0, "carried out")                             \
  X(unknown_operation, 1, "nothing done")               \
  X(bad_index, 2, "nothing done")                       \
  X(bad_value, 3, "nothing done; the value is in force")
// clang-format on

#define RS_OPERATION_NUMBER(name, number, index, value) RS_OPERATION_##name = (number),
typedef enum { RS_OPERATIONS(RS_OPERATION_NUMBER) RS_OPERATION_LIMIT } rs_operation;
#undef RS_OPERATION_NUMBER

#define RS_REPLY_STATUS_NUMBER(name, number, text) RS_REPLY_##name = (number),
typedef enum { RS_REPLY_STATUSES(RS_REPLY_STATUS_NUMBER) RS_REPLY_STATUS_LIMIT } rs_reply_status;
#undef RS_REPLY_STATUS_NUMBER

#endif
