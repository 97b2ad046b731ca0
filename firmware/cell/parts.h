/* What the parts of a cell's firmware offer each other. Ports are indices 0 to 3 here. */
#ifndef ROBOTSKIN_CELL_PARTS_H
#define ROBOTSKIN_CELL_PARTS_H

#include <stddef.h>
#include <string.h>

#include "robotskin/cell.h"
#include "robotskin/crc.h"
#include "robotskin/feasibility.h"
#include "robotskin/operations.h"
#include "robotskin/timing.h"

enum { RS_ALL_PORTS = (1 << RS_PORTS) - 1 };

/* Whether time a is at or after time b, on a clock that wraps. */
RS_INLINE bool rs_reached(uint32_t a, uint32_t b) {
  return (int32_t)(a - b) >= 0;
}

/* What is left of a time after whole periods, and how many they are. Of a time of a few periods, that is of any but in
 * damaged memory, a small processor finds it sooner than by a division. */
RS_INLINE uint32_t rs_left_of(uint32_t time_us, uint32_t period_us, uint32_t* periods) {
  *periods = 0;
  for (unsigned turn = 0; turn < 4U; ++turn) {
    if (time_us < period_us) return time_us;
    time_us -= period_us;
    ++*periods;
  }
  *periods += time_us / period_us;
  return time_us % period_us;
}

/* Copies a frame; both begin at a whole word. */
RS_INLINE void rs_frame_copy(uint8_t* to, const uint8_t* from) {
#if defined(__GNUC__)
  __builtin_memcpy(__builtin_assume_aligned(to, 4), __builtin_assume_aligned(from, 4), RS_FRAME_BYTES);
#else
  memcpy(to, from, RS_FRAME_BYTES);
#endif
}

/* Spreads any number over 32 bits: phases and jitters that differ from cell to cell. */
RS_INLINE uint32_t rs_spread(uint32_t x) {
  x ^= x >> 16;
  x *= 0x7FEB352DU;
  x ^= x >> 15;
  x *= 0x846CA68BU;
  return x ^ (x >> 16);
}

/* ---- network/wave.c: what a root fixes in its ticks, and its tag ---- */
enum { RS_TICK_TIME_BITS = 26 };
RS_INLINE uint32_t rs_wave_time(const rs_wave* wave) {
  return ((uint32_t)wave->era << 16) | wave->sequence;
}
uint32_t rs_wave_tag(const rs_chaskey_key* key, const rs_wave* wave);
RS_INLINE void rs_wave_of_tick(rs_wave* wave, const rs_tick* tick) {
  *wave = (rs_wave){.tag = tick->tag,
                    .sequence = (uint16_t)tick->sequence,
                    .era = (uint16_t)tick->era,
                    .root = (uint8_t)tick->root,
                    .forming = (uint8_t)tick->forming,
                    .depth_cap = (uint8_t)tick->depth_cap,
                    .rate_divisor = (uint8_t)tick->rate_divisor,
                    .gain_threshold = (uint8_t)tick->gain_threshold};
}
RS_INLINE bool rs_waves_equal(const rs_wave* a, const rs_wave* b) {
#if defined(RS_FRAMES_AT_WORDS)
  uint32_t first[4], second[4]; /* little-endian; of the last one, the bytes that have no name do not count */
  RS_STATIC_ASSERT(sizeof first == sizeof *a && offsetof(rs_wave, none) == 13, "a wave is four words");
  __builtin_memcpy(first, a, sizeof first);
  __builtin_memcpy(second, b, sizeof second);
  return first[0] == second[0] && first[1] == second[1] && first[2] == second[2] &&
         ((first[3] ^ second[3]) & 0xFFU) == 0U;
#else
  return a->tag == b->tag && a->sequence == b->sequence && a->era == b->era && a->root == b->root &&
         a->forming == b->forming && a->depth_cap == b->depth_cap && a->rate_divisor == b->rate_divisor &&
         a->gain_threshold == b->gain_threshold;
#endif
}
/* The tag of a joints frame of an epoch, whose number the frame tells modulo 64. */
uint32_t rs_joints_tag(const rs_chaskey_key* key, const uint8_t frame[RS_FRAME_BYTES], uint32_t epoch);
/* The tag of a command or grant frame sent in an era. */
uint32_t rs_command_tag(const rs_chaskey_key* key, const uint8_t frame[RS_FRAME_BYTES], uint32_t era);

/* ---- network/links.c: which neighbours are there (R1) ---- */
bool rs_link_usable(const rs_neighbour* neighbour);
void rs_link_damage(rs_neighbour* neighbour, uint32_t now_us); /* a damaged frame has come */
/* Whether so many frames from there are damaged that another line is better. */
bool rs_link_spoilt(const rs_neighbour* neighbour, uint32_t now_us);
void rs_link_heard(rs_cell* cell, unsigned port, uint32_t now_us);
void rs_link_down(rs_cell* cell, unsigned port, uint32_t now_us);
/* Whether a child has stayed behind the own ticks for longer than any move takes. */
bool rs_link_lagging(const rs_route* route, const rs_neighbour* neighbour, uint32_t now_us);
void rs_links_check(rs_cell* cell, uint32_t now_us);

/* ---- network/adverts.c: what the neighbours say of themselves (R8) ---- */
void rs_advert_tick(rs_cell* cell, unsigned port, const uint8_t* frame, uint32_t now_us);

/* ---- network/route.c: the parent (R2 to R7, R9) ---- */
void rs_route_boot(rs_cell* cell, uint32_t now_us);
void rs_route_turn(rs_cell* cell, unsigned port, uint32_t now_us); /* after what a neighbour has said */
void rs_route_lose(rs_cell* cell, uint32_t now_us);
void rs_route_adopt(rs_cell* cell, unsigned port, uint32_t now_us); /* R3; only what is feasible */
void rs_route_advertise(rs_cell* cell, uint32_t now_us);            /* to every neighbour, now */
bool rs_route_feasible(const rs_route* route, unsigned port);       /* R2 */
/* Whether the way up begins with a line that spoils frames. */
RS_INLINE bool rs_route_spoilt(const rs_route* route, uint32_t now_us) {
  return route->parent_port != RS_NO_PARENT &&
         rs_link_spoilt(&route->neighbour[(route->parent_port - 1U) % RS_PORTS], now_us);
}
void rs_route_check(rs_cell* cell, uint32_t now_us);
uint32_t rs_tick_time(const rs_cell* cell, uint32_t now_us); /* milliseconds, RS_TICK_TIME_BITS bits */

/* ---- network/moves.c: planned changes of parent (R10) ---- */
void rs_move_grant(rs_cell* cell, unsigned port, const uint8_t* frame, uint32_t now_us); /* a grant frame */
/* Leaves a parent that is about to leave the tree for an equally near one that stays; false if there is none. */
bool rs_move_shed(rs_cell* cell, uint32_t now_us);
/* Begins to leave a parent that hangs at the border for a farther one that does not. */
void rs_move_detour(rs_cell* cell, uint32_t now_us);
/* What an advert of another neighbour than the parent means for a move; true if the cell has moved. */
bool rs_move_advance(rs_cell* cell, unsigned port, uint32_t now_us);
/* After so long a move is given up. */
RS_INLINE uint32_t rs_move_longest_us(const rs_route* route) {
  return route->target_root == route->wave.root ? RS_DETOUR_US : RS_HOLD_US;
}
void rs_move_check(rs_cell* cell, uint32_t now_us);
/* Whether a neighbour may become the parent by a move: its ticks come as fast as the own ones, and it stays. */
bool rs_move_open(const rs_route* route, const rs_neighbour* neighbour);

/* ---- network/offers.c: which cell of the subtree could move to another tree ---- */
bool rs_wants_open(const rs_route* route);
/* The better of a subtree's best offer and the own one; `lean_*` of what would move with this cell. */
void rs_offer_own(const rs_cell* cell, uint32_t lean_size, rs_offer* best);
void rs_offer_better(const rs_route* route, const rs_offer* offer, rs_offer* best);

/* ---- network/subtree.c: status frames ---- */
void rs_subtree_update(rs_cell* cell);
void rs_subtree_forget(rs_neighbour* neighbour); /* a new child has not reported yet */
void rs_subtree_status(rs_cell* cell, unsigned port, const uint8_t* frame);
void rs_subtree_pack(rs_cell* cell, uint8_t* frame);

/* ---- network/identity.c: naming and topology reports ---- */
void rs_identity_boot(rs_cell* cell, uint32_t random, uint32_t now_us);
void rs_identity_changed(rs_cell* cell, uint32_t now_us); /* a report is due soon */
void rs_identity_check(rs_cell* cell, uint32_t now_us);
void rs_identity_assign(rs_cell* cell, uint16_t id, uint32_t now_us);
void rs_identity_rejoin(rs_cell* cell, uint32_t now_us);

/* ---- network/retention.c ---- */
/* Take a frame to be sent to the parent and kept for a while; false: no room. An event that is here already counts as
 * taken; a torque sum gets its serial. */
bool rs_retention_event(rs_cell* cell, const uint8_t* frame, uint32_t now_us);
bool rs_retention_torque(rs_cell* cell, const rs_torque* torque, uint32_t now_us);
bool rs_retention_torque_waits(const rs_cell* cell);
bool rs_retention_next_event(rs_cell* cell, uint8_t* frame, uint32_t now_us);
bool rs_retention_next_torque(rs_cell* cell, uint8_t* frame, uint32_t now_us);
/* A tick has come: of the parent, or of a child (`was_child`: that was one before). */
void rs_retention_tick(rs_cell* cell, unsigned port, const rs_tick* tick, bool was_child, uint32_t now_us);
uint32_t rs_retention_announce(rs_cell* cell);          /* `echo` of the next tick to the parent */
void rs_retention_move(rs_cell* cell, uint32_t now_us); /* the parent has changed */
RS_INLINE void rs_retention_follow(rs_cell* cell, uint32_t now_us) {
  const rs_retention* retention = &cell->retention;
  if (retention->parent_port != cell->route.parent_port || retention->parent_changes != cell->counts.parent_changes) {
    rs_retention_move(cell, now_us);
  }
}
void rs_retention_check(rs_cell* cell, uint32_t now_us);
/* Age of a sample by its frame. What a cell holds for longer than the sample times go round never gets here. */
uint32_t rs_sample_age_us(const rs_cell* cell, const uint8_t* frame, uint32_t now_us);

/* ---- network/torque_epoch.c ---- */
void rs_torque_receive(rs_cell* cell, unsigned port, const uint8_t* frame, uint32_t now_us);
void rs_torque_advance(rs_cell* cell, uint32_t now_us); /* begins epochs and ends them */
RS_INLINE void rs_torque_follow(rs_cell* cell, uint32_t now_us) {
  const rs_torque_epoch* epoch = &cell->torque;
  if (epoch->open || cell->route.origin_us != epoch->origin_us || rs_reached(now_us, epoch->begin_us)) {
    rs_torque_advance(cell, now_us);
  }
}
uint32_t rs_torque_wait_us(const rs_cell* cell, uint32_t now_us);
void rs_torque_check(rs_cell* cell);

/* ---- network/queues.c ---- */
bool rs_queue_up(rs_cell* cell, const uint8_t* frame,
                 uint32_t now_us);                       /* by its type; false: no room. It begins at a whole word */
void rs_queue_down(rs_cell* cell, const uint8_t* frame); /* to every child */
/* The subtree has another size than before. If it has grown to more than a line carries, every other sample is left
 * out, those that a rate divisor of two would leave out as well, until the section unit has had time to tell its own.
 */
void rs_queues_crowd(rs_cell* cell, uint32_t before, uint32_t size);
RS_INLINE void rs_queues_calm(rs_cell* cell) { /* with each tick */
  uint8_t* most = &cell->queues.data_most;
  if (*most < RS_QUEUE_DATA) *most = *most < RS_QUEUE_CALMED ? (uint8_t)(*most + 1U) : (uint8_t)RS_QUEUE_DATA;
}
void rs_queues_forget_samples(rs_cell* cell);
void rs_queues_turn(rs_cell* cell); /* nothing waits to go down to the parent, which was a child perhaps */
/* The last samples wait again, */
void rs_queues_repeat_lost(rs_cell* cell, uint32_t since_us, uint32_t now_us); /* as the parent was silent since then */
void rs_queues_repeat_spoilt(rs_cell* cell, uint32_t now_us);                  /* as few frames come through to it */
void rs_queues_check(rs_cell* cell, uint32_t now_us);

/* ---- network/transmit.c: the next frame of each idle port ---- */
uint32_t rs_advert_wait_us(const rs_cell* cell, unsigned port, uint32_t now_us); /* until it may be sent; 0: now */
uint32_t rs_status_wait_us(const rs_cell* cell, uint32_t now_us);                /* likewise */
void rs_transmit(rs_cell* cell, uint32_t now_us, rs_output* output);
/* Starts a frame on each of these ports (bit p: port p) that has one; on which it did. */
unsigned rs_transmit_start(rs_cell* cell, unsigned ready, uint32_t now_us);
/* Tells the frames that have started. */
RS_INLINE void rs_output_start(rs_output* output, const rs_queues* queues, unsigned started) {
  for (unsigned port = 0; port < RS_PORTS; ++port) output->frame[port] = 0;
  for (unsigned port = 0; started != 0U; ++port, started >>= 1) {
    if ((started & 1U) != 0U) output->frame[port % RS_PORTS] = queues->sending[port % RS_PORTS];
  }
}
/* Ports with something to send, now or as soon as they are free. */
RS_INLINE unsigned rs_transmit_wanted(const rs_cell* cell) {
  const rs_queues* queues = &cell->queues;
  if (queues->down.count > 0U) return RS_ALL_PORTS;
  const unsigned parent = 1U << cell->route.parent_port >> 1;
  return (queues->advert_due | (queues->status_due || rs_cell_waiting(cell) > 0U ? parent : 0U)) & RS_ALL_PORTS;
}

/* ---- network/step.c ---- */
/* rs_cell_step the long way: whatever comes, and whatever is due. */
void rs_step(rs_cell* cell, const rs_input* input, uint32_t now_us, rs_output* output);

/* ---- network/passing.c: the short way of what comes most often ---- */
/* After a step the long way: until when the short one may be taken. */
void rs_pass_note(rs_cell* cell, uint32_t now_us);
/* Frames that are out (bit p: port p), as `sent` of the input that comes next. */
RS_INLINE void rs_note_sent(rs_cell* cell, unsigned sent) {
  cell->queues.busy &= (uint8_t)~sent;
}

/* ---- cell/sampling.c ---- */
uint32_t rs_sampling_period_us(const rs_settings* settings); /* 0: never */
void rs_sampling_restart(rs_cell* cell, uint32_t now_us);    /* after a change of settings or id, or the first tick */
void rs_sampling_refresh(rs_cell* cell, uint32_t now_us);    /* a frame for freshness is due, soon */
void rs_sampling_check(rs_cell* cell, uint32_t now_us);      /* heals what damaged memory says of the next sample */
/* Whether the rate divisor, or one of two while there is none, leaves out a sample of any cell that comes by. */
bool rs_sampling_left_out(const rs_cell* cell, const uint8_t* frame, uint32_t now_us);
void rs_sampling_take(rs_cell* cell, const rs_sample* sample, bool fault, uint32_t now_us);

/* ---- cell/joints.c ---- */
void rs_joints_receive(rs_cell* cell, const uint8_t* frame, uint32_t now_us);

/* ---- cell/own_torque.c ---- */
void rs_own_torque_load(rs_cell* cell); /* from the cell's flash image */
void rs_own_torque_feel(rs_cell* cell, const rs_sample* calibrated, uint32_t now_us);
/* What the cell adds to its limb's sum in an epoch, by what it has felt and how the joints stand. */
void rs_own_torque_update(rs_cell* cell, uint32_t epoch, uint32_t now_us);
void rs_own_torque_write(rs_cell* cell, const rs_command* word); /* of an index that there is */
bool rs_own_torque_commit(rs_cell* cell, uint32_t checksum);     /* false: what was written is not that */
uint32_t rs_own_torque_checksum(const rs_cell* cell);            /* of what is in force, 65536: nothing is */

/* ---- cell/commands.c ---- */
void rs_command_receive(rs_cell* cell, unsigned port, const uint8_t* frame, uint32_t now_us);

/* Notes that uid, id or key are as they should be. */
void rs_cell_seal(rs_cell* cell);

/* Indices that damaged memory could carry out of their arrays before the next check. */
RS_INLINE void rs_cell_hold_indices(rs_cell* cell) {
  if (cell->route.parent_port > RS_PORTS) cell->route.parent_port = RS_NO_PARENT;
  if (cell->retention.announcements > RS_ANNOUNCEMENTS) cell->retention.announcements = 0;
  if (cell->torque.used > RS_TORQUE_SLOTS) cell->torque.used = 0;
}

/* A sum of whole halfwords, `count` bytes of them; never 0. */
uint32_t rs_sum_of(const void* halfwords, uint32_t count);

/* Notes that the settings are as they should be; heals them if they are not, from the copy or from flash. */
void rs_cell_keep_settings(rs_cell* cell);
void rs_cell_heal_settings(rs_cell* cell, uint32_t now_us);

/* When the next check is due; called by whoever changes one of its reasons. */
void rs_timer_set(rs_cell* cell, uint32_t now_us);

#endif
