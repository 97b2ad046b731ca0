/* SPDX-License-Identifier: Apache-2.0
 * The periods and limits of the network, in microseconds. */
#ifndef ROBOTSKIN_TIMING_H
#define ROBOTSKIN_TIMING_H

#include "robotskin/wire.h"

enum {
  RS_TORQUE_FAITH = 2, /* epochs for which a child that has reported is waited for */
  RS_FRAME_US = RS_FRAME_BYTES * RS_LINK_BITS_PER_BYTE * 1000 / (RS_LINK_BAUD / 1000), /* 50: one frame on a link */
  RS_TICK_US = 1000,
  RS_HEARTBEAT_US = 1500,                          /* a cell that hears no new tick speaks up by itself */
  RS_BEACONS = 4,                                  /* ticks of a port, at most, */
  RS_BEACONS_US = 1000,                            /* in any span of this length */
  RS_SENDING_US = 3000,                            /* no frame goes out for so long */
  RS_LINK_UP_FRAMES = 3,                           /* valid frames before a link counts */
  RS_LINK_DOWN_US = 3500,                          /* without a valid frame: three heartbeats missed */
  RS_QUARANTINE_US = RS_LINK_DOWN_US + RS_TICK_US, /* after boot, until every child of before has noticed */
  RS_STALE_US = 4500,         /* own sequence stands still: a fresher neighbour may take over from a living parent */
  RS_STALE_TICKS = 4,         /* ... if it is this much ahead */
  RS_STALE_LIMIT_US = 20000,  /* a path this stale is lost, alternative or not */
  RS_ORPHAN_RESET_US = 12000, /* without parent and child: the feasible distance is forgotten */
  RS_ORPHAN_KEEP_US = 8000,   /* samples held for a new parent are dropped after this: their time stamps wrap */
  RS_SEQUENCE_WINDOW = 16,    /* ticks a neighbour may be ahead of a living parent */
  RS_HOLD_DOWN_US = 8000,     /* after a second loss of a link, doubling with each further one */
  RS_HOLD_DOWN_MAX_US = 2000000,
  RS_HOLD_DOWN_ALONE_US = 20000, /* a cell that has been cut off for so long holds no link down */
  RS_LOSSY_US = 4000,            /* what a damaged frame adds to a line's bucket, from which time takes, */
  RS_LOSSY_MANY_US = 5000,       /* when that is full enough for going elsewhere, */
  RS_LOSSY_MAX_US = 12000,       /* and when it is full */
  RS_FLAP_FORGET_US = 1000000,   /* a link that held so long starts anew */
  RS_STATUS_US = 8000,           /* to the parent, at least so often, */
  RS_STATUS_PAUSE_US = 300,      /* with at least so long between two, */
  RS_STATUS_BURST = 24,          /* so many in short order, */
  RS_STATUS_MEAN_US = 3300,      /* and on the average one in so long */
  RS_HOLD_US = 2000,             /* a planned move not done by then is given up: behind it others may wait for a tick */
  RS_DETOUR_US = 900,            /* likewise a move within the tree: the next tick finds it done or given up */
  RS_DETOUR_PAUSE_US = 16000,    /* from one to the next, at least */
  RS_DEMANDS_TICKS = 24,         /* wants so old are forgotten */
  RS_GRANT_TICKS = 2,            /* between two grants of a tree */
  RS_REST_TICKS = 64,            /* a cell that has moved does not offer itself again for so long */
  RS_BALANCE_TICKS = 8,          /* a round of wants */
  RS_SETTLE_TICKS = 6,           /* after a grant, until sizes are right again */
  RS_FORMING_TICKS = 20,         /* without a change of the trees' sizes: they are formed */
  RS_FORMING_MIN_TICKS = 40,     /* from the first tree on, at least */
  RS_GAIN_FORMING = 1,           /* hops to gain before a change of root */
  RS_GAIN_STEADY = 24,           /* more than any granted move costs, so that no cell is pulled back */
  RS_DEPTH_RAISE_MAX = 4,        /* hops that balance may cost */
  RS_PEER_US = 4000,             /* between two datagrams to the other units of a group */
  RS_PEER_SILENCE_US = 30000,    /* without one, a unit counts no more */
  RS_PEER_STARTING_US = 3000,    /* a unit that ticks for less takes the group's time, and none takes its */
  RS_PEER_TOGETHER_US = 16000,   /* units apart by less are pulled together gently, others leap */
  RS_PEER_PULL_US = 50,          /* by so much a tick */
  RS_PEER_LEAP_MS = 30000,       /* longest leap: half the tick numbers are newer */
  RS_ARQ_BACK_US = 600,          /* from going back to frames that were missed until the parent knows it */
  RS_REPEAT_US = 1000,           /* clock frames taken so long before a parent fell silent are sent to the new one, */
  RS_REPEAT_MOST_US = 7000,      /* but none older than this; so old ones again over a line that spoils frames, */
  RS_LOSSY_SILENT_US = 2000,     /* and since so long such a line counts as silent to a cell that leaves it */
  RS_ARQ_LATE_US = 500,          /* where a tick has waited so long for the processor, events are missing for good */
  RS_ARQ_KEEP_US = 12000,        /* an event is kept so long after its sample: longer, its time could not be told */
  RS_TORQUE_RETRY_US = 3000,     /* a torque sum is sent again for so long: the parent cannot have forgotten it */
  RS_TORQUE_LATE_US = 8000,      /* one that found no parent is given up after this */
  RS_TORQUE_EARLY_US = 250,      /* a report may come so long before the own clock begins its epoch */
  RS_TORQUE_WAIT_US = 400,       /* after the epoch's begin a cell waits for its children's torque sums so long, */
  RS_TORQUE_HOP_US = 100,        /* so much more for each hop below it */
  RS_TORQUE_FRAME_US = 100,      /* and each frame of a report there, */
  RS_TORQUE_WAIT_MAX_US = 3400,  /* and at most so long, */
  RS_TORQUE_WAY_US = 80,         /* less this for each hop to the root */
  RS_TORQUE_END_US = 3700,       /* after the epoch's begin a section unit hands over what it has */
  RS_ORDER_US = 200,             /* from a command or joint state down a cable to the next: a cell takes some 130 */
  RS_TOPOLOGY_US = 1000000,      /* between two reports at most, */
  RS_TOPOLOGY_EARLY_US = 250000, /* and up to so much less: reports that crowd each other out once do not again */
  RS_TOPOLOGY_PAUSE_US = 4000,   /* from a change to its report, at least */
  RS_TOPOLOGY_SPREAD_US = 32000, /* and at most so much more */
  RS_TAG_FORGIVEN_US = 1000000,  /* of a place's wrong tags one is forgiven in so long */
  RS_JOIN_SPREAD_US = 16000,     /* over which cells first ask for an id */
  RS_JOIN_US = 20000,            /* between two requests for an id */
  RS_REFRESH_US = 100000,        /* a cell is silent at most so long, and a jitter by cell and frame */
  RS_REFRESH_JITTER_US = 20000,
  RS_REFRESH_SPREAD_US = 16000, /* over which the cells of a tree refresh that have reason to at once */
  RS_FRESH_US = 250000,         /* promised to the host: two refreshes, one of them lost, and the way */
  RS_AGE_STEP_US = 4            /* of a tick's age: so it holds 63 hops of cells whose processor takes its time */
};

/* A tick's age as it stands in its frame: to the nearest step, as each hop rounds again. */
RS_INLINE uint32_t rs_tick_age(uint32_t age_us) {
  const uint32_t steps = (age_us + RS_AGE_STEP_US / 2U) / RS_AGE_STEP_US;
  return steps > RS_FIELD_MAX(tick_age_4us) ? RS_FIELD_MAX(tick_age_4us) : steps;
}

RS_STATIC_ASSERT(2 * ((int)RS_REFRESH_US + (int)RS_REFRESH_JITTER_US) < (int)RS_FRESH_US, "one refresh may be lost");

#endif
