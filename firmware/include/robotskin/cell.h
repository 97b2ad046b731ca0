/* SPDX-License-Identifier: Apache-2.0
 * A cell: sensors in, frames out, its place in the network kept by itself.
 *
 * rs_cell_step is the whole firmware: a pure function of state, input and time. What runs it (a board, the
 * simulator, a test) owns clock, links and sensors, gives one input at a time, and does what the output says:
 *
 * - RS_INPUT_BOOT first, once after each power-up and whenever an output asks for a `restart`; it forgets everything
 *   but the flash image.
 * - A frame in the output goes out on its port, which gets no other until RS_INPUT_SENT is given for it: when the frame
 *   is out, 50 us later at 4 Mb/s, or sooner where the board lets frames wait behind it. Its bytes stay where they are,
 *   inside the state, until RS_FRAMES_OUT - 1 others of that port have been given. Where the output's `waiting` does
 *   not name the port, nothing is gained by a step of its own: the next input's `sent` tells it as well (a chip enables
 *   its transmitter's interrupt only while more is to be sent).
 * - RS_INPUT_TIMER at or after `timer_us`, RS_INPUT_SAMPLE at or after `sample_us` (if `sampling`). Both times hold
 *   until the next output; an early, late or unasked timer does no harm.
 * - Frames are given as received: the cell checks and counts them. A frame with RS_FRAME_BYTES bytes that fails its
 *   checksum is counted as lost; boundaries are found by receiver.h.
 *
 * `now_us` is the cell's own clock; it wraps every 71 minutes, starts anywhere and may run 2 % fast or slow. */
#ifndef ROBOTSKIN_CELL_H
#define ROBOTSKIN_CELL_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/arq_receiver.h"
#include "robotskin/arq_sender.h"
#include "robotskin/channels.h"
#include "robotskin/chaskey.h"
#include "robotskin/geometry.h"
#include "robotskin/keys.h"
#include "robotskin/settings.h"
#include "robotskin/timing.h"
#include "robotskin/torque.h"
#include "robotskin/torque_parameters.h"
#include "robotskin/wire.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Input ---- */

enum {
  RS_FLASH_TORQUE_AT = RS_SETTINGS_BYTES, /* behind the settings: the torque parameters */
  RS_FLASH_BYTES = RS_SETTINGS_BYTES + RS_TORQUE_IMAGE_BYTES
};

typedef struct {
  uint32_t uid;         /* serial number, unique and never 0 */
  uint32_t random;      /* fresh at each boot */
  const uint8_t* flash; /* image of RS_FLASH_BYTES, or NULL */
  const uint8_t* keys;  /* RS_CELL_KEYS_BYTES (keys.h), or NULL: ticks and commands are not authenticated */
  uint16_t step_us;     /* from an input that a beacon answers until that goes out: the processor's time, a mean */
} rs_boot;

typedef enum { RS_INPUT_BOOT, RS_INPUT_FRAME, RS_INPUT_SENT, RS_INPUT_SAMPLE, RS_INPUT_TIMER } rs_input_kind;

typedef struct {
  rs_input_kind kind;
  uint8_t port;            /* 1 to 4; of FRAME and SENT */
  uint8_t sent;            /* bit p - 1: the frame on port p has gone out since the last input */
  bool checked;            /* of FRAME: its checksum is known to be right */
  bool fault;              /* of SAMPLE: a sensor is missing or saturated */
  uint16_t late_us;        /* of FRAME: it came so long before `now_us`; 0 where the board does not know */
  const uint8_t* frame;    /* RS_FRAME_BYTES; of FRAME */
  const rs_sample* sample; /* of SAMPLE */
  const rs_boot* boot;     /* of BOOT */
} rs_input;

/* ---- Output ---- */

typedef struct {
  const uint8_t* frame[RS_PORTS]; /* frame to start on port p at index p - 1, or NULL */
  uint32_t timer_us;
  uint32_t sample_us;
  uint32_t led_rgb; /* 0xRRGGBB, valid if led_changed */
  uint8_t waiting;  /* bit p - 1: port p is wanted as soon as its frame is out */
  bool sampling;    /* sample_us is valid */
  bool led_changed;
  bool flash_changed;   /* write `flash` to flash */
  bool restart;         /* not booted, or its memory is damaged: boot it */
  const uint8_t* flash; /* RS_FLASH_BYTES inside the state, valid if flash_changed */
} rs_output;

/* ---- State: read by checkers and viewers, written by the cell alone ----
 * Truths are bytes, 0 or not, so that damaged memory holds none that C does not know. */

enum {
  RS_QUEUE_DATA = 64,    /* clock frames of the subtree */
  RS_LINE_CELLS = 70,    /* a line carries at 250 Hz. Where more have come, */
  RS_QUEUE_CROWDED = 12, /* so many clock frames may wait before every other one is left out, one more each tick, */
  RS_QUEUE_CALMED = 24,  /* and as many as there is room for after this many */
  RS_QUEUE_SLOW = 32,    /* replies, topology and join frames of the subtree */
  RS_QUEUE_DOWN = 16,    /* commands on their way down */
  RS_FRAMES_OUT = 4,     /* frames that a board may have of a port: one goes out, the others wait behind it */
  RS_NO_PARENT = 0       /* parent_port */
};

/* The budget of wrong tags (routing/wrong_tags.h), by place: ports, and what a good neighbour passes on unread. */
enum {
  RS_TAGS_BUDGET = 16,   /* wrong tags in short order; time gives one back in RS_TAG_FORGIVEN_US. One more, */
  RS_TAGS_CLOSED_S = 10, /* and so long nothing is read there; */
  RS_TAGS_TOLD_S = 10,   /* then so long the host is still told, and the next wrong tag closes it again */
  RS_UNREAD = RS_PORTS,
  RS_TAG_PLACES = RS_PORTS + 1
};

/* What the root fixed in a tick, passed on unchanged. */
typedef struct {
  uint32_t tag;
  uint16_t sequence;
  uint16_t era;
  uint8_t root;
  uint8_t forming;
  uint8_t depth_cap;
  uint8_t rate_divisor;
  uint8_t gain_threshold;
  uint8_t none[3]; /* named, so that equal states are equal in every byte */
} rs_wave;

/* The fields of a tick frame that say so. */
RS_INLINE void rs_wave_into_tick(rs_tick* tick, const rs_wave* wave) {
  tick->tag = wave->tag;
  tick->sequence = wave->sequence;
  tick->era = wave->era;
  tick->root = wave->root;
  tick->forming = wave->forming;
  tick->depth_cap = wave->depth_cap;
  tick->rate_divisor = wave->rate_divisor;
  tick->gain_threshold = wave->gain_threshold;
}

enum {
  RS_DEMANDS = 3,      /* trees a root can want to give cells to at once */
  RS_FOREIGN_ROOTS = 3 /* roots beside its subtree that a cell reports at once */
};

/* What a root wants its tree to give away, from its grant frames. */
typedef struct {
  uint16_t sequence;          /* tick number of the last such frame */
  uint16_t size[RS_DEMANDS];  /* most cells to move at once */
  uint8_t target[RS_DEMANDS]; /* roots that may receive them, 0: none */
  uint8_t root;
  uint8_t round;
  uint8_t open;        /* 0: nothing is wanted */
  uint8_t last_resort; /* no cell has offered itself: those at the border let go */
  uint8_t none;
} rs_demands;

/* A cell that could move to another tree; `cell` RS_ID_NONE: none. */
typedef struct {
  uint16_t cell;
  uint16_t size; /* cells that would move */
  uint8_t delta; /* hops the move costs */
  uint8_t root;  /* where to */
  uint8_t round; /* of the wants it answers */
  uint8_t none;
} rs_offer;

/* What is known of the neighbour at one port. */
typedef struct {
  rs_wave wave;                 /* its last accepted beacon */
  rs_arq_receiver arq_receiver; /* of its events and torque sums; if it is a child */
  uint32_t origin_us;           /* when the root sent that tick, cell's clock */
  uint32_t heard_us;            /* last valid frame */
  uint32_t turned_us;           /* when its wave last became another one */
  uint32_t poisoned_us;         /* when it last said that it has no way to a root */
  uint32_t up_us;               /* link up since */
  uint32_t hold_down_until_us;
  uint32_t lost;            /* frames with a wrong checksum, */
  uint32_t damage_until_us; /* and how full their bucket is: when it will be empty */
  uint16_t id;
  uint16_t size;            /* of its subtree; if it is a child */
  uint16_t size_complement; /* of `size`: a damaged one must not thin out a whole tree */
  rs_offer offer;           /* the best of its subtree */
  uint8_t foreign[RS_FOREIGN_ROOTS];
  uint8_t height; /* of its subtree */
  uint8_t hops;   /* as announced */
  uint8_t nonce;
  uint8_t port;             /* 1 to 4: the neighbour's own port */
  uint8_t good;             /* valid frames since the link was down, at most RS_LINK_UP_FRAMES */
  uint8_t flaps;            /* link losses in short order, */
  uint8_t flaps_complement; /* and its complement: damaged memory must not keep a link out */
  uint8_t met;              /* nonce and beacon have been heard */
  uint8_t up;               /* enough valid frames, none missed */
  uint8_t hears_us;         /* says that it hears this cell */
  uint8_t child;            /* says that this cell is its parent */
  uint8_t draining;
  uint8_t lagging;   /* a child that does not take over the own ticks: nothing hangs on it */
  uint8_t hold_down; /* kept out until hold_down_until_us */
  uint8_t stale;     /* its wave has stood still: no way to a root, whatever it says */
} rs_neighbour;

typedef struct {
  rs_neighbour neighbour[RS_PORTS];
  rs_wave wave;         /* the tick this cell passes on */
  uint32_t origin_us;   /* when the root sent that tick, cell's clock */
  uint32_t advanced_us; /* when the sequence last advanced */
  uint32_t orphaned_us;
  uint32_t beacon_sent_us;
  uint32_t reported_us;       /* last status to the parent */
  uint32_t status_spent_us;   /* until then, status frames sent count against the burst */
  uint32_t quarantine_us;     /* end of quarantine, if in_quarantine */
  uint16_t feasible_sequence; /* feasible distance: a beacon must come strictly before it to be adopted */
  uint8_t feasible_hops;
  uint8_t hops;
  uint8_t parent_port; /* RS_NO_PARENT or 1 to 4 */
  uint8_t in_quarantine;
  uint8_t unbound; /* no feasible distance yet: any beacon may be adopted */
  uint8_t timed;   /* a tick has been adopted since boot: wave and origin give the time */

  /* A planned move: while `handover`, no new tick of the old parent is adopted */
  uint8_t handover;
  uint8_t resting; /* has moved at tick number `moved_sequence`, and offers itself not for a while */
  uint16_t moved_sequence;
  uint8_t target_port; /* 1 to 4: the parent to be */
  uint8_t target_root;
  uint8_t draining_ticks; /* ticks, 255 at most, since it hangs at the border to a tree that shall grow: children that
                       need not hang on it leave */
  uint16_t handover_size; /* most cells that may move with this one */
  uint16_t told_size;     /* least size in an own offer told to the parent in round `told_round` */
  uint8_t told_round;
  uint32_t handover_us; /* since */

  /* Tick time of the last adopted tick, and its complement: it says which ticks are played again, so it has to be
   * right. Where the two disagree, no time is known. */
  uint32_t known_time, known_time_complement;

  /* The subtree, for the parent's status */
  rs_demands demands;
  rs_offer offer;
  uint8_t foreign[RS_FOREIGN_ROOTS]; /* roots seen beside it, 0: none */
  uint8_t foreign_turn;              /* which is left out if there are more */
  uint16_t subtree_size;
  uint8_t subtree_height;
} rs_route;

/* A ring of frames. */
typedef struct {
  uint8_t first, count;
} rs_ring;

typedef struct {
  /* What every frame asks for stands within the reach of a small processor's shortest instructions. */
  uint32_t calm_us; /* until then nothing but traffic is to be done, and the short way may be taken (passing.c) */
  rs_ring data, slow, down;
  uint8_t busy;         /* bit p - 1: a frame is going out on port p */
  uint8_t beacon_due;   /* bit p - 1: port p is to get a tick frame */
  uint8_t waiting;      /* bit p - 1: something waits for port p, as of the last step */
  uint8_t parent_port;  /* 1 to 4: the parent's, while calm, */
  uint8_t parent_bit;   /* its bit, */
  uint8_t samples_next; /* and whether a sample is the next frame for it, if one waits */
  uint8_t status_due;
  uint8_t size_due;               /* the status tells a new size or depth, which the rate divisor waits for */
  uint8_t passed_over;            /* frames sent to the parent while slow ones waited */
  uint8_t data_passed_over;       /* ... and while clock frames waited */
  uint8_t data_most;              /* so many clock frames may wait before every other one is left out */
  uint8_t data_sent;              /* clock frames before the first one that were sent lately and are still there */
  uint8_t data_again;             /* of those that wait, the first so many have been sent before */
  uint8_t sending_last[RS_PORTS]; /* of the frames of a port, the one that was started last */
  uint32_t data_sent_us;          /* when the last one was sent */
  uint32_t started_us[RS_PORTS];  /* when the frame that is going out started */
  uint32_t beacon_us[RS_PORTS][RS_BEACONS]; /* when a port got its last beacons, */
  uint8_t beacon_next[RS_PORTS];            /* the oldest of them here */
  uint8_t down_ports[RS_QUEUE_DOWN];        /* bit p - 1: still to go out on port p */
  RS_WORDS uint8_t sending[RS_PORTS][RS_FRAMES_OUT][RS_FRAME_BYTES];
  RS_WORDS uint8_t data_frame[RS_QUEUE_DATA][RS_FRAME_BYTES];
  RS_WORDS uint8_t slow_frame[RS_QUEUE_SLOW][RS_FRAME_BYTES];
  RS_WORDS uint8_t down_frame[RS_QUEUE_DOWN][RS_FRAME_BYTES];
} rs_queues;

typedef struct {
  uint32_t due_us;
  uint8_t running;
  uint8_t sequence;
  uint32_t sent_us; /* last own frame */
  int32_t sent_value[RS_CHANNEL_COUNT];
  uint8_t refresh_due;
  uint32_t refresh_us; /* not before this time, so that a tree does not refresh all at once */
  uint8_t dropped;     /* to be told in the next own frame */
} rs_sampling;

typedef struct {
  uint32_t time; /* tick time, milliseconds, at which the last counted command came */
  uint32_t sum;  /* of time and counter: where it is wrong, no command has been counted */
  uint16_t counter;
  uint8_t counted; /* counter and time are valid */
  uint8_t replied;
  RS_WORDS uint8_t reply[RS_FRAME_BYTES]; /* to the last command, repeated if that comes again */
} rs_commanding;

/* X(name, meaning) */
// clang-format off
#define RS_CELL_COUNTS(X)                                                  \
  X(frames_damaged, "received with a wrong checksum")                       \
  X(frames_unknown, "received with a type that has no business there")      \
  X(frames_dropped, "not passed on: a queue was full or the route too long lost") \
  X(repeats_dropped, "not passed on, of those that come again by themselves: topology and join")  \
  X(hops_exhausted, "not passed on: no hops left")                          \
  X(frames_from_parent, "samples that came down the tree")                  \
  X(tags_refused, "ticks, commands and joints with a wrong tag or an old time")     \
  X(commands_stale, "commands and joints that had come before")                         \
  X(torques_dropped, "torque sums that came from no child, too late, or found no room") \
  X(torques_saturated, "epochs in which an own torque was beyond the range of its limb's sums") \
  X(parent_changes, "changes of parent")                                    \
  X(orphanings, "times without any parent")
// clang-format on

/* What the cell itself adds to its limb's torque. */
typedef struct {
  rs_torque_parameters parameters;
  uint32_t sum;     /* of the parameters' bytes, 0: there are none; by which damaged memory is told */
  uint32_t own_sum; /* of the contribution that was given from outside, likewise */
  uint32_t felt_us; /* time of the sample that `force` is of */
  int32_t force;    /* that touch asks for, RS_FORCE_BITS */
  uint8_t known;    /* the parameters are */
  uint8_t felt;     /* force and time are valid */
} rs_cell_torque;

#define RS_COUNT_MEMBER(name, text) uint32_t name;
typedef struct {
  RS_CELL_COUNTS(RS_COUNT_MEMBER)
} rs_cell_counts;
#undef RS_COUNT_MEMBER

typedef struct {
  uint32_t uid;
  uint16_t id; /* in force; RS_ID_NONE until named */
  uint16_t challenge;
  rs_queues queues; /* near the beginning, see there */
  uint8_t nonce;
  uint8_t keyed;
  uint16_t step_us;                   /* of rs_boot */
  uint32_t identity_checksum;         /* check sum of what lasts from boot to boot: uid, id and keys */
  uint8_t led_changed, flash_changed; /* to be told in the output of this step */
  uint8_t topology_revision;
  uint8_t wrong_tags[RS_TAG_PLACES], wrong_tags_complement[RS_TAG_PLACES]; /* lately, and how long a place is closed */
  uint32_t forgiven_us;                                                    /* when they were last fewer by one */
  uint32_t timer_us;
  rs_sampling sampling;
  rs_route route;
  uint32_t led_rgb, led_complement; /* where they disagree, that colour was not asked for */
  uint32_t topology_us, join_us;    /* next due */
  rs_commanding commanding;
  rs_settings settings, settings_copy; /* the same; each with its sum, by which damaged memory is told */
  uint32_t settings_sum, settings_copy_sum;
  rs_cell_counts counts;
  rs_chaskey_key key;                           /* of ticks */
  RS_WORDS uint8_t turn_key[RS_CELL_KEY_BYTES]; /* in this turn (keys.h), of what else is for all cells */
  RS_WORDS uint8_t keys[RS_CELL_KEYS_BYTES];    /* from which those of a turn come */
  uint32_t turn;                                /* RS_TURN_NONE until it is named */
  uint8_t flash[RS_FLASH_BYTES];
  rs_torque_epoch torque;
  rs_cell_torque cell_torque;
  rs_joints_state joints;
  rs_arq_sender arq_sender;
} rs_cell;

RS_STATIC_ASSERT(sizeof(rs_cell) <= 8192, "a cell's state must leave room on a part with 12 KB of RAM");

/* One input at one time. `output` is filled completely. An input that names no port 1 to 4, or a frame that is no valid
 * frame, changes nothing but counters. */
void rs_cell_step(rs_cell* cell, const rs_input* input, uint32_t now_us, rs_output* output);

/* What the cell adds to its limb's torque from the next epoch on, in place of what it computes, as long as it has no
 * torque parameters; a limb or a number of parts that there is not adds nothing. */
void rs_cell_contribute(rs_cell* cell, const rs_contribution* contribution);

/* Frames that wait for the parent. */
RS_INLINE uint32_t rs_cell_waiting(const rs_cell* cell) {
  const rs_arq_sender* arq_sender = &cell->arq_sender;
  return (uint32_t)(arq_sender->event.count - arq_sender->event.sent) +
         (uint32_t)(arq_sender->torque.count - arq_sender->torque.sent) + cell->queues.data.count +
         cell->queues.slow.count;
}

#ifdef __cplusplus
}
#endif

#endif
