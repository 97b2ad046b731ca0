/* SPDX-License-Identifier: Apache-2.0
 * A section unit: roots of the cell trees at its ports, and the bridge between frames and datagrams.
 *
 * Like a cell it is a pure step: what runs it owns clock, links and sockets. It names cells, sends the tick every
 * millisecond on each port, tags commands, gathers upward frames into datagrams of at most `batch_us` age and opens the
 * host's datagrams. The keyed hash is a hook, so that the one well-kept BLAKE2s of the host is linked, not written
 * again.
 *
 * `now_ns` is the unit's own clock. The units of a group agree on one time (peers.c); its milliseconds are the tick
 * numbers, and the datagrams to the host carry it. */
#ifndef ROBOTSKIN_SECTION_UNIT_H
#define ROBOTSKIN_SECTION_UNIT_H

#include <stdbool.h>
#include <stdint.h>

#include "robotskin/cell.h"
#include "robotskin/datagram.h"
#include "robotskin/wire.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Writes the tag (keyed BLAKE2s-256, first 16 bytes) of `count` bytes. */
typedef void (*rs_tag_hook)(void* context, const uint8_t* bytes, uint32_t count, uint8_t tag[RS_DATAGRAM_TAG_BYTES]);

typedef struct {
  uint16_t group;    /* of section units: the name space of cell ids */
  uint8_t unit;      /* 0 to 15 within the group */
  uint8_t ports;     /* 1 to 15 */
  uint16_t first_id; /* ids this unit may give, apart from those of other units of the group */
  uint16_t last_id;
  uint32_t batch_us;       /* a frame waits at most this long for a datagram to fill; 0: one frame a datagram */
  uint32_t session;        /* drawn at each start, never 0 */
  bool powered;            /* ports are on from the start */
  bool unasked;            /* sends datagrams without keep-alives (recorders, tests) */
  const uint8_t* cell_key; /* the secret from which cells' keys come (keys.h), or NULL */
  /* Turns of the ticks' time before those that the clock tells (keys.h): 0 for a clock that never starts anew, else a
   * number that is greater at each power-up; the same in all units of a group. */
  uint32_t turns;
  rs_tag_hook tag; /* NULL: datagrams are not authenticated */
  void* tag_context;
} rs_section_unit_config;

typedef enum {
  RS_UNIT_INPUT_BOOT,
  RS_UNIT_INPUT_FRAME,
  RS_UNIT_INPUT_SENT,
  RS_UNIT_INPUT_DATAGRAM,
  RS_UNIT_INPUT_TIMER
} rs_unit_input_kind;

typedef struct {
  rs_unit_input_kind kind;
  uint8_t port;                         /* 1 to 15; of FRAME and SENT */
  const uint8_t* bytes;                 /* frame (RS_FRAME_BYTES) or datagram */
  uint32_t count;                       /* bytes of a datagram */
  const rs_section_unit_config* config; /* of BOOT */
} rs_unit_input;

typedef struct {
  const uint8_t* frame[RS_SECTION_UNIT_PORTS_MAX]; /* frame to start on port p at index p - 1, or NULL; as in cell.h */
  const uint8_t* datagram;                         /* valid until the next step; or NULL */
  uint32_t datagram_bytes;
  bool to_peers;     /* the datagram goes to every other unit of the group instead of the host; any may be lost */
  uint64_t timer_ns; /* RS_UNIT_INPUT_TIMER at or after this time; it may be `now` again */
  uint16_t power;    /* bit p - 1: port p has power */
} rs_unit_output;

enum {
  RS_UNITS_MAX = 16,                         /* in a group */
  RS_UNIT_NAMES_MAX = 4096,                  /* cells a unit can name */
  RS_UNIT_QUEUE = 128,                       /* frames waiting to go down a port */
  RS_UNIT_SILENCE_MS = 10 * RS_KEEP_ALIVE_MS /* without word from the host the unit falls silent */
};

enum { RS_UNIT_BESIDE = RS_PEER_NEIGHBOURS, RS_UNIT_GRANTED = 8 };

/* Balance at one port: which trees are beside its own, and what it is giving away. Times are ticks. */
typedef struct {
  uint8_t beside[RS_UNIT_BESIDE]; /* roots, 0: free */
  uint64_t beside_seen[RS_UNIT_BESIDE];
  rs_offer offer; /* last one heard */
  uint16_t demand_size[RS_DEMANDS];
  uint8_t demand_root[RS_DEMANDS]; /* 0: none */
  uint16_t gap[RS_DEMANDS];        /* cells by which that tree was smaller when the round was opened */
  uint16_t given[RS_DEMANDS];      /* granted to it in this round, */
  uint8_t given_root[RS_DEMANDS];  /* whose root this is: it counts until the sizes are right again */
  uint8_t round;
  bool open;           /* a round of wants is under way */
  bool last_resort;    /* cells at the border let go: rounds before found no offer */
  uint8_t demand_left; /* frames still to send */
  uint8_t granted_next;
  uint16_t granted[RS_UNIT_GRANTED]; /* last cells granted in this round */
  uint16_t failed;                   /* rounds in a row without an offer */
  uint64_t opened_at;
  uint64_t decide_at;  /* offers are collected until then */
  uint64_t close_at;   /* the round ends if no offer comes by then */
  uint64_t busy_until; /* no new wants before */
  uint8_t depth_cap;   /* 0: none yet */
  uint8_t base_depth;  /* what the cap was raised from */
  uint8_t steady;      /* rounds without a change of the trees' number and total size */
  uint8_t stalled;     /* rounds without progress */
  uint16_t trees;      /* of the component, and its total size and sum of squares at best */
  uint32_t cells;
  uint16_t base_trees;
  uint32_t base_cells;
  uint64_t best_squares;
} rs_unit_balance;

/* The rate divisor of a port: what its cells would send, against what the port carries. */
typedef struct {
  uint32_t samples;    /* clock frames heard in this window, */
  uint32_t sums;       /* and torque frames */
  uint32_t line;       /* frames of any kind in this short window */
  uint16_t rate_hz;    /* samples a cell takes each second, as far as known; at most 250 */
  uint16_t sums_hz;    /* torque frames of the tree each second */
  uint16_t ticks;      /* of this window */
  uint16_t size;       /* of the tree in this window, 0: it has changed */
  uint16_t low_ticks;  /* for which a smaller divisor would have done */
  uint16_t hold_ticks; /* after cells lost frames, until a smaller divisor is tried again */
  uint16_t hold_next_ticks;
  uint8_t rise,
      rise_ticks;  /* least divisor that would have done in each of the last ticks; ticks for which more would */
  uint8_t floor;   /* least divisor until then */
  uint8_t divisor; /* in force */
  bool overflowed; /* cells lost frames in the last short window */
  bool drops;      /* a cell has said in this short window that it lost frames, */
  bool lossy;      /* or in the long one */
} rs_unit_rate;

enum { RS_UNIT_TORQUE_SLOTS = 64 }; /* limbs and parts */

/* One epoch of torque sums. */
typedef struct {
  rs_torque_sum slot[RS_UNIT_TORQUE_SLOTS];
  uint64_t given;    /* bit i: slot i has been handed over; what comes after that only counts as expected */
  uint64_t number;   /* tick time / 4 */
  uint16_t reported; /* bit p - 1: port p has reported */
  uint8_t used;
  bool open;
  bool late; /* something came after its sum was handed over */
} rs_unit_epoch;

typedef struct {
  rs_unit_epoch epoch;
  uint16_t expected[16][4];                   /* cells, by limb and part */
  uint8_t reports[RS_SECTION_UNIT_PORTS_MAX]; /* epochs for which the port is still waited for */
  uint8_t missing;                            /* epochs handed over incomplete in a row */
  uint32_t complete, incomplete, late;        /* epochs; frames that came after their sum was handed over */
} rs_unit_torque;

typedef struct {
  uint64_t heard_ns;
  uint64_t turned_ns;             /* the cell there last said a new tick, */
  uint16_t sequence;              /* this one */
  uint32_t frames, lost, dropped; /* received whole, damaged; not sent down because the queue was full */
  uint16_t cell;                  /* at this port; 0: none named */
  uint16_t size;                  /* of its tree, as reported by `status` */
  uint8_t height;
  uint8_t cell_port; /* 1 to 4 */
  uint8_t good;
  bool root; /* the cell there has this port as parent, and is not stuck */
  bool busy;
  uint64_t ordered_ns; /* when the next command or joint state may go down */
  bool tick_due;
  uint32_t tag; /* of the current tick */
  rs_unit_balance balance;
  uint8_t nonce; /* of the cell there, by its ticks */
  bool met;      /* nonce is valid */
  rs_arq_receiver arq_receiver;
  rs_unit_rate rate;
  uint8_t queue_first, queue_count;
  uint8_t sending[RS_FRAME_BYTES];
  uint8_t queue[RS_UNIT_QUEUE][RS_FRAME_BYTES];
} rs_unit_port;

typedef struct {
  uint32_t uid; /* 0: free */
  uint16_t id;  /* 0: known, but named elsewhere */
} rs_unit_name;

/* The names a unit has given, as an open-addressed table by uid. */
typedef struct {
  rs_unit_name entry[2 * RS_UNIT_NAMES_MAX];
  uint8_t taken[(RS_ID_LAST + 8) / 8]; /* bit by id */
  uint32_t uid_of[RS_ID_LAST + 1];     /* by id, of any unit's cells, as last heard; 0: none */
  uint32_t count;
  uint16_t next_id;
  uint32_t refused; /* requests without a free id */
} rs_unit_ids;

/* Another unit of the group, as heard over Ethernet. */
typedef struct {
  uint64_t heard_ns; /* own clock, last accepted datagram */
  uint64_t time_ns;  /* the group's time in it */
  uint64_t ahead_ns; /* its time minus the own clock, modulo 2^64 */
  uint32_t session, sequence;
  uint32_t sent_ns;       /* its clock in that datagram, to be echoed */
  uint32_t round_trip_ns; /* of the exchanges that count */
  uint8_t flags;
  bool heard;     /* the fields above are valid */
  bool mutual;    /* it hears this unit too */
  bool timed;     /* ahead_ns is valid */
  uint16_t ports; /* bit p - 1: `tree[p - 1]` is valid */
  rs_peer_tree tree[RS_SECTION_UNIT_PORTS_MAX];
} rs_unit_peer;

typedef struct {
  rs_section_unit_config config;
  rs_chaskey_key key;                  /* of ticks, */
  uint8_t turn_key[RS_CELL_KEY_BYTES]; /* and of what else is for all cells, in this turn */
  uint32_t turn;
  rs_unit_port port[RS_SECTION_UNIT_PORTS_MAX];
  rs_unit_ids ids;
  uint64_t tick_time; /* milliseconds; number of the last tick */
  uint64_t ahead_ns;  /* the group's time minus the own clock, modulo 2^64 */
  uint64_t booted_ns; /* own clock */
  uint64_t leapt_ns;  /* own clock: the group's time was last set by a leap */
  uint64_t heartbeat_ns;
  uint16_t power;

  /* Host */
  uint64_t host_heard_ns, host_time_ns;
  uint32_t host_session, host_sequence, sequence;
  uint32_t dropped;         /* frames without a place */
  uint32_t refused;         /* datagrams */
  uint16_t command_counter; /* last one flooded */
  bool host_heard;
  bool hurry; /* the records do not wait for more */

  rs_unit_torque torque;

  /* Balance */
  bool forming;
  uint32_t cells;         /* in all trees at the last tick */
  uint64_t cells_since;   /* tick of their last change */
  uint64_t forming_since; /* tick of the first tree */
  uint32_t grants;        /* so far */

  /* The other units of the group, by number */
  rs_unit_peer peer[RS_UNITS_MAX];
  uint64_t peers_due_ns; /* own clock: next datagram to them */
  uint32_t peers_sequence;

  /* Records that wait for a datagram */
  uint64_t arrival_ns[RS_DATAGRAM_RECORDS_MAX];
  uint32_t waiting;
  uint8_t record[RS_DATAGRAM_RECORDS_MAX][RS_DATAGRAM_RECORD_BYTES];
  uint8_t datagram[RS_DATAGRAM_BYTES_MAX];
} rs_section_unit;

/* One input at one time; `output` is filled completely. After BOOT with a bad configuration (ports, ids, session) the
 * unit does nothing and its timer never comes. */
void rs_section_unit_step(rs_section_unit* unit, const rs_unit_input* input, uint64_t now_ns, rs_unit_output* output);

#ifdef __cplusplus
}
#endif

#endif
