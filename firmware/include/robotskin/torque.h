/* SPDX-License-Identifier: Apache-2.0
 * Torques summed on their way up the tree, once an epoch of four ticks.
 *
 * All cells begin an epoch at the same instant, each by its own knowledge of the tick time, so that sums go up without
 * waiting for the tick to come down. Each cell sends one report an epoch: its own contribution and those of the
 * children that reported in time. The sum of a limb's part leaves as soon as every child has reported that had it in
 * one of the last two epochs; the last frame says that the report is complete. A child counts on being waited for once
 * it has reported; what comes too late is passed on as it is and added further up or in the section unit. Nothing
 * is sent where no cell contributes. */
#ifndef ROBOTSKIN_TORQUE_H
#define ROBOTSKIN_TORQUE_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/geometry.h"
#include "robotskin/wire.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  RS_EPOCH_TICKS = 4,
  RS_EPOCH_MASK = 0x3F,  /* of an epoch's number on the wire */
  RS_TORQUE_PARTS = 2,   /* of one cell's chain: 12 joints */
  RS_TORQUE_AGE_MAX = 7, /* epochs: no torque is computed from joint positions that are older */
  RS_TORQUE_SLOTS = 4    /* limbs and parts that a cell can sum; what is beyond is passed on unsummed */
};

/* What a cell adds in each epoch, until it is told otherwise: torque in the limb's step for joints 1 to 6 `parts`. */
typedef struct {
  int32_t joint[RS_TORQUE_PARTS * RS_JOINTS_PER_PART];
  uint8_t limb;   /* 0 to 15 */
  uint8_t parts;  /* 0: nothing */
  uint8_t age;    /* epochs of the joint state it was computed from */
  uint8_t active; /* the cell is in contact */
} rs_contribution;

/* Joint positions as broadcast, in 2 pi / 65536 rad, or m with 15 fraction bits: those of the limb that the cell
 * contributes to. */
typedef struct {
  int16_t position[RS_TORQUE_PARTS * RS_JOINTS_PER_PART];
  uint32_t epoch[RS_TORQUE_PARTS]; /* of each part */
  uint8_t newest[16][4];           /* low bits of the newest epoch heard, by limb and part */
  uint32_t latest;                 /* tick time of the newest epoch of all limbs and parts, */
  uint32_t latest_complement;      /* and its complement: a damaged one must not keep out what comes */
  uint8_t known[16];               /* by limb; bit p: part p has been heard */
  uint8_t limb;                    /* whose positions these are */
  uint8_t received_mask;           /* bit p: part p of them */
} rs_joints_state;

/* The sum of one part of one limb. */
typedef struct {
  int32_t joint[RS_JOINTS_PER_PART];
  uint16_t cells, active;
  uint8_t limb, part, age;
  uint8_t saturated;
} rs_torque_sum;

/* The epoch of a cell. */
typedef struct {
  rs_contribution own;
  rs_torque_sum slot[RS_TORQUE_SLOTS];
  uint8_t from[RS_TORQUE_SLOTS];     /* bit p - 1: the child at port p has reported this sum */
  uint8_t before[RS_TORQUE_SLOTS];   /* ... in the epoch before */
  uint8_t expected[RS_TORQUE_SLOTS]; /* children for which this sum waits */
  uint32_t deadline_us;              /* the report leaves then, complete or not */
  uint32_t begin_us;                 /* when the next epoch begins */
  uint32_t origin_us;                /* of the tick by which that is known */
  uint32_t epoch;                    /* tick time / 4 */
  uint8_t used;                      /* slots */
  uint8_t filled;                    /* bit i: slot i holds what has not been sent */
  uint8_t waiting;                   /* bit p - 1: the child at port p has yet to report */
  uint8_t reports[RS_PORTS];         /* epochs for which the child at port p is still waited for */
  uint8_t open;                      /* the report is not complete */
} rs_torque_epoch;

void rs_torque_sum_start(rs_torque_sum* sum, uint32_t limb, uint32_t part);
void rs_torque_sum_add(rs_torque_sum* sum, const rs_torque* torque);
/* As it goes on the wire, held at the ends of its fields. */
void rs_torque_sum_frame(const rs_torque_sum* sum, uint32_t epoch, bool last, rs_torque* torque);

#ifdef __cplusplus
}
#endif

#endif
