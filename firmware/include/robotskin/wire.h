/* SPDX-License-Identifier: Apache-2.0
 * The wire format between cells: the only place where a frame is laid out.
 *
 * A frame is 20 bytes: 144 bits of content, most significant bit first, then a 16-bit checksum (crc.h). Links carry
 * nothing but frames, so a receiver finds their boundaries by the checksum and needs no delimiter.
 * Every frame is a list of fields X(name, signed, bits, meaning); from it come the struct `rs_NAME`, the functions
 * `rs_NAME_pack` and `rs_NAME_unpack`, the bit table in docs/protocol.md and the Python bindings. */
#ifndef ROBOTSKIN_WIRE_H
#define ROBOTSKIN_WIRE_H

#include <stdint.h>

#include "robotskin/channels.h"
#include "robotskin/frame_bits.h"
#include "robotskin/geometry.h"
#include "robotskin/portable.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  RS_FRAME_BYTES = 20,
  RS_FRAME_BITS = 8 * RS_FRAME_BYTES,
  RS_CHECKSUM_BITS = 16,
  RS_CONTENT_BYTES = RS_FRAME_BYTES - 2,
  RS_CONTENT_BITS = RS_FRAME_BITS - RS_CHECKSUM_BITS,
  RS_ID_NONE = 0,              /* not named yet, or no neighbour */
  RS_ID_SECTION_UNIT = 0x3FFF, /* the neighbour is a section unit; as a command's target: every cell */
  RS_ID_ALL = 0x3FFF,
  RS_ID_FIRST = 1,
  RS_ID_LAST = 0x3FFE,
  RS_HOPS_POISON = 255, /* "do not route through me" */
  RS_TTL_START = 63,
  RS_HOPS_MAX = RS_TTL_START + 1, /* of a cell: from further away no frame gets to the root */
  RS_LINK_BAUD = 4000000,
  RS_LINK_BITS_PER_BYTE = 10, /* 8N1 */
  RS_CELLS_PER_PORT = 66,     /* at 250 Hz: 82.5 % of 80 */
  RS_JOINTS_PER_PART = 6,
  RS_FIRMWARE_VERSION = 3 /* grows when cells, units and hosts of before no longer understand; 0: it was not told yet */
};

/* X(name, number, from which sender to which receiver) */
#define RS_FRAME_TYPES(X)                                                                        \
  X(clock, 1, "cell to host: one sample, at the clock rate")                                     \
  X(event, 2, "cell to host: one sample, because a channel changed")                             \
  X(tick, 3, "to every neighbour: heartbeat, route beacon, clock")                               \
  X(status, 4, "cell to parent: its subtree, and offers for balance")                            \
  X(grant, 5, "section unit to its tree: wants, and leave for one cell to move")                 \
  X(joints, 6, "host to all cells: joint positions of one epoch")                                \
  X(torque, 7, "cell to parent: summed joint torques of one epoch")                              \
  X(topology, 8, "cell to host: identity and port-to-port neighbours")                           \
  X(command, 9, "host to one cell or all")                                                       \
  X(reply, 10, "cell to host: answer to a command")                                              \
  X(join, 11, "cell to section unit: a cell without an id asks for one")                         \
  X(further, 12, "cell to host: one sample of the channels that a sample frame has no room for") \
  X(key, 13, "host to a cell without keys, alone on its line, and back: its keys")

#define RS_TYPE_NUMBER(name, number, text) RS_TYPE_##name = (number),
typedef enum { RS_FRAME_TYPES(RS_TYPE_NUMBER) RS_TYPE_LIMIT = 16 } rs_frame_type;
#undef RS_TYPE_NUMBER

// clang-format off
/* X(name, signed, bits, meaning) */
/* Sample frames carry the absolute values of all channels, so each one alone makes its cell fresh. The names of the
 * channels are those of channels.h. */
#define RS_SAMPLE_FIELDS(X)                                                           \
  X(type, 0, 4, "frame type")                                                         \
  X(source, 0, 14, "id of the cell")                                                  \
  X(sequence, 0, 8, "counts the cell's sample frames")                                \
  X(ttl, 0, 6, "hops left")                                                           \
  X(sample_tick, 0, 4, "sample time: low bits of the tick number")                    \
  X(sample_phase, 0, 6, "sample time: elapsed 64ths of the tick period")              \
  X(refresh, 0, 1, "sent for freshness or after a change of route, not for an event") \
  X(fault, 0, 1, "a sensor is missing or saturated")                                  \
  X(retransmitted, 0, 1, "sent again after a change of route")                        \
  X(dropped, 0, 1, "the cell had to drop samples since its last one")                 \
  X(proximity, 0, 16, "counts")                                                       \
  X(force_1, 0, 10, "counts")                                                         \
  X(force_2, 0, 10, "counts")                                                         \
  X(force_3, 0, 10, "counts")                                                         \
  X(acceleration_x, 1, 10, "counts")                                                  \
  X(acceleration_y, 1, 10, "counts")                                                  \
  X(acceleration_z, 1, 10, "counts")                                                  \
  X(temperature_1, 1, 8, "counts")                                                    \
  X(temperature_2, 1, 14, "counts")

/* The channels behind the nine, in their order (channels.h); what a board does not have is 0. What passes samples on
 * finds all that it asks for at the same place. */
#define RS_FURTHER_FIELDS(X)                                                        \
  X(type, 0, 4, "frame type")                                                       \
  X(source, 0, 14, "id of the cell")                                                \
  X(sequence, 0, 8, "of the cell's next sample frame")                              \
  X(ttl, 0, 6, "hops left")                                                         \
  X(sample_tick, 0, 4, "sample time: low bits of the tick number")                  \
  X(sample_phase, 0, 6, "sample time: elapsed 64ths of the tick period")            \
  X(spare_1, 0, 1, "")                                                              \
  X(fault, 0, 1, "a sensor is missing or saturated")                                \
  X(retransmitted, 0, 1, "sent again after a change of route")                      \
  X(spare_2, 0, 3, "")                                                              \
  X(value_1, 0, 16, "counts of the tenth channel, signed ones as two's complement") \
  X(value_2, 0, 16, "of the eleventh")                                              \
  X(value_3, 0, 16, "of the twelfth")                                               \
  X(value_4, 0, 16, "of the thirteenth")                                            \
  X(value_5, 0, 16, "of the fourteenth")                                            \
  X(value_6, 0, 16, "of the fifteenth")

#define RS_CLOCK_FIELDS(X) RS_SAMPLE_FIELDS(X)
#define RS_EVENT_FIELDS(X) RS_SAMPLE_FIELDS(X)

/* The tag covers what the root fixed: era, sequence, root, forming, depth cap, rate divisor, gain threshold. What each
 * hop changes cannot be covered. Tick time is 65536 era + sequence, in milliseconds. */
#define RS_TICK_FIELDS(X)                                              \
  X(type, 0, 4, "frame type")                                          \
  X(sequence, 0, 16, "tick number, one a millisecond")                 \
  X(hops, 0, 8, "of the sender; 255: do not route through me")         \
  X(root, 0, 8, "section unit (4 bits) and its port (4 bits)")         \
  X(sender, 0, 14, "id, 0: not named yet")                             \
  X(sender_port, 0, 2, "the sender's port - 1")                        \
  X(nonce, 0, 8, "drawn at the sender's boot")                         \
  X(parent, 0, 1, "the receiver is the sender's parent")               \
  X(heard, 0, 1, "the sender hears the receiver")                      \
  X(draining, 0, 1, "the sender is about to change its parent")        \
  X(forming, 0, 1, "the network is being formed")                      \
  X(depth_cap, 0, 8, "deepest hops a granted move may reach")          \
  X(rate_divisor, 0, 4, "cells send every n-th sample")                \
  X(gain_threshold, 0, 6, "hops to gain before a change of root")      \
  X(ack, 0, 8, "to the parent: number of the next event or torque frame; to a child: arq_receiver.h") \
  X(age_4us, 0, 12, "4 us: from the root's start of sending to this frame's") \
  X(era, 0, 10, "wraps of sequence")                                   \
  X(tag, 0, 32, "of what the root fixed")

#define RS_STATUS_FIELDS(X)                                           \
  X(type, 0, 4, "frame type")                                         \
  X(sender, 0, 14, "id")                                              \
  X(size, 0, 16, "cells in the subtree")                              \
  X(height, 0, 8, "hops to the deepest cell")                         \
  X(candidate, 0, 14, "cell that offers to move, 0: none")            \
  X(candidate_size, 0, 16, "cells that would move")                   \
  X(candidate_delta, 0, 4, "hops the move costs")                     \
  X(candidate_root, 0, 8, "where to")                                 \
  X(candidate_round, 0, 3, "of the wants it answers")                 \
  X(foreign_1, 0, 8, "a root seen next to the subtree, 0: none")      \
  X(foreign_2, 0, 8, "another one")                                   \
  X(foreign_3, 0, 8, "another one")                                   \
  X(ack, 0, 8, "sequence of the last event heard on this link")       \
  X(spare, 0, 25, "")

#define RS_GRANT_FIELDS(X)                                       \
  X(type, 0, 4, "frame type")                                    \
  X(sequence, 0, 16, "tick number")                              \
  X(root, 0, 8, "root that grants")                              \
  X(round, 0, 3, "counts changes of the wants")                  \
  X(cell, 0, 14, "cell that may move, 0: none")                  \
  X(target_root, 0, 8, "where to")                               \
  X(demand_1_root, 0, 8, "root that may receive cells, 0: none") \
  X(demand_1_size, 0, 11, "how many at once")                    \
  X(demand_2_root, 0, 8, "another one")                          \
  X(demand_2_size, 0, 11, "how many at once")                    \
  X(demand_3_root, 0, 8, "another one")                          \
  X(demand_3_size, 0, 11, "how many at once")                    \
  X(spare, 0, 1, "")                                             \
  X(last_resort, 0, 1, "no cell has offered itself")             \
  X(tag, 0, 32, "of all before it and the second")

#define RS_JOINTS_FIELDS(X)                         \
  X(type, 0, 4, "frame type")                       \
  X(epoch, 0, 6, "low bits of tick number / 4")     \
  X(limb, 0, 4, "")                                 \
  X(part, 0, 2, "joints 6 part + 1 to 6 part + 6")  \
  X(joint_1, 1, 16, "position in 2 pi / 65536 rad") \
  X(joint_2, 1, 16, "position in 2 pi / 65536 rad") \
  X(joint_3, 1, 16, "position in 2 pi / 65536 rad") \
  X(joint_4, 1, 16, "position in 2 pi / 65536 rad") \
  X(joint_5, 1, 16, "position in 2 pi / 65536 rad") \
  X(joint_6, 1, 16, "position in 2 pi / 65536 rad") \
  X(tag, 0, 32, "of all before it")

/* `serial` and `last` are of one hop: a frame is sent again under its serial, and the last one of a report says that no
 * more are to be waited for. */
#define RS_TORQUE_FIELDS(X)                                        \
  X(type, 0, 4, "frame type")                                      \
  X(epoch, 0, 6, "low bits of tick number / 4")                    \
  X(limb, 0, 4, "")                                                \
  X(part, 0, 2, "joints 6 part + 1 to 6 part + 6")                 \
  X(joint_1, 1, 16, "torque in the limb's step")                   \
  X(joint_2, 1, 16, "torque in the limb's step")                   \
  X(joint_3, 1, 16, "torque in the limb's step")                   \
  X(joint_4, 1, 16, "torque in the limb's step")                   \
  X(joint_5, 1, 16, "torque in the limb's step")                   \
  X(joint_6, 1, 16, "torque in the limb's step")                   \
  X(cells, 0, 12, "summed, at most 4095")                          \
  X(active, 0, 10, "of them in contact, at most 1023")             \
  X(age, 0, 3, "epochs of the oldest joint state used, at most 7") \
  X(saturated, 0, 1, "a sum left its range")                       \
  X(serial, 0, 5, "counts the sender's torque frames")             \
  X(last, 0, 1, "the sender's report of this epoch is complete")

/* Sent on change, else within a second. A neighbour 16383 is a section unit, 0 none. A section unit reports a port
 * by a record of that port with source 16383 and the cell there as neighbour 1. */
#define RS_TOPOLOGY_FIELDS(X)                                           \
  X(type, 0, 4, "frame type")                                           \
  X(source, 0, 14, "id of the cell")                                    \
  X(uid, 0, 32, "the cell's serial number")                             \
  X(revision, 0, 6, "counts changes")                                   \
  X(parent_port, 0, 3, "1 to 4, 0: none")                               \
  X(ttl, 0, 6, "hops left")                                             \
  X(closed, 0, 3, "port closed by wrong tags, now or lately; 5: orders under its own key") \
  X(neighbour_1, 0, 14, "id of the cell at port 1")                     \
  X(neighbour_port_1, 0, 2, "the port it uses - 1")                     \
  X(errors_1, 0, 3, "binary digits of the count of frames lost there, at most 7") \
  X(neighbour_2, 0, 14, "id of the cell at port 2")                     \
  X(neighbour_port_2, 0, 2, "the port it uses - 1")                     \
  X(errors_2, 0, 3, "binary digits of the count of frames lost there, at most 7") \
  X(neighbour_3, 0, 14, "id of the cell at port 3")                     \
  X(neighbour_port_3, 0, 2, "the port it uses - 1")                     \
  X(errors_3, 0, 3, "binary digits of the count of frames lost there, at most 7") \
  X(neighbour_4, 0, 14, "id of the cell at port 4")                     \
  X(neighbour_port_4, 0, 2, "the port it uses - 1")                     \
  X(errors_4, 0, 3, "binary digits of the count of frames lost there, at most 7")

/* Flooded down the tree: a cell takes commands only from its parent. */
#define RS_COMMAND_FIELDS(X)                      \
  X(type, 0, 4, "frame type")                     \
  X(target, 0, 14, "id, 16383: every cell")       \
  X(operation, 0, 6, "operations.h")              \
  X(counter, 0, 16, "grows with each command")    \
  X(index, 0, 16, "what of")                      \
  X(value_high, 0, 16, "upper part of the value") \
  X(value_low, 0, 32, "value")                    \
  X(spare, 0, 8, "")                              \
  X(tag, 0, 32, "of all before it and the second")

#define RS_REPLY_FIELDS(X)                        \
  X(type, 0, 4, "frame type")                     \
  X(source, 0, 14, "id of the cell")              \
  X(ttl, 0, 6, "hops left")                       \
  X(operation, 0, 6, "of the command")            \
  X(counter, 0, 16, "of the command")             \
  X(status, 0, 4, "operations.h")                 \
  X(index, 0, 16, "of the command")               \
  X(value_high, 0, 16, "upper part of the value") \
  X(value_low, 0, 32, "value now in force")       \
  X(version, 0, 8, "of the firmware that answers") \
  X(spare, 0, 22, "")

#define RS_JOIN_FIELDS(X)                                 \
  X(type, 0, 4, "frame type")                             \
  X(uid, 0, 32, "the cell's serial number")               \
  X(ttl, 0, 6, "hops left")                               \
  X(nonce, 0, 8, "drawn at boot")                         \
  X(wanted, 0, 14, "id in the cell's flash, or 0")        \
  X(challenge, 0, 16, "comes back in the assign command") \
  X(spare_1, 0, 32, "")                                   \
  X(spare_2, 0, 32, "")

/* Only a cell without keys reads or sends such a frame (commissioning.h). */
#define RS_KEY_FIELDS(X)                                           \
  X(type, 0, 4, "frame type")                                      \
  X(step, 0, 4, "commissioning.h")                                 \
  X(spare, 0, 8, "")                                               \
  X(word_1, 0, 32, "a serial number, or the beginning of a key")   \
  X(word_2, 0, 32, "a version or a check, or a key goes on")       \
  X(word_3, 0, 32, "the key goes on")                              \
  X(word_4, 0, 32, "its end")
// clang-format on

RS_INLINE rs_frame_type rs_frame_type_of(const uint8_t* bytes) {
  return (rs_frame_type)(bytes[0] >> 4);
}

#define RS_MEMBER_0(name) uint32_t name;
#define RS_MEMBER_1(name) int32_t name;
#define RS_MEMBER(name, is_signed, bits, text) RS_MEMBER_##is_signed(name)
#define RS_GET_0(name, at, bits) out->name = rs_bits_get(words, (at), (bits));
#define RS_GET_1(name, at, bits) out->name = rs_sign_extend(rs_bits_get(words, (at), (bits)), (bits));

/* Defines struct, positions, pack and unpack of one frame. `pack` writes 18 content bytes; crc.h adds the checksum. */
#define RS_DEFINE_FRAME(name, FIELDS)                                                           \
  enum { FIELDS(RS_POSITION_##name) RS_##name##_BITS };                                         \
  RS_STATIC_ASSERT((int)RS_##name##_BITS == (int)RS_CONTENT_BITS, #name " must fill 144 bits"); \
  typedef struct {                                                                              \
    FIELDS(RS_MEMBER)                                                                           \
  } rs_##name;                                                                                  \
  RS_INLINE void rs_##name##_unpack(rs_##name* out, const uint8_t* bytes) {                     \
    uint32_t words[5];                                                                          \
    rs_content_load(words, bytes);                                                              \
    FIELDS(RS_UNPACK_##name)                                                                    \
  }                                                                                             \
  RS_INLINE void rs_##name##_pack(uint8_t* bytes, const rs_##name* in) {                        \
    uint32_t words[5] = {0, 0, 0, 0, 0};                                                        \
    FIELDS(RS_PACK_##name)                                                                      \
    rs_content_store(bytes, words);                                                             \
  }

#define RS_POSITION_clock(name, is_signed, bits, text) \
  RS_clock_##name##_AT, RS_clock_##name##_LAST = RS_clock_##name##_AT + (bits) - 1,
#define RS_UNPACK_clock(name, is_signed, bits, text) RS_GET_##is_signed(name, RS_clock_##name##_AT, bits)
#define RS_PACK_clock(name, is_signed, bits, text) rs_bits_put(words, RS_clock_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(clock, RS_CLOCK_FIELDS)

#define RS_POSITION_event(name, is_signed, bits, text) \
  RS_event_##name##_AT, RS_event_##name##_LAST = RS_event_##name##_AT + (bits) - 1,
#define RS_UNPACK_event(name, is_signed, bits, text) RS_GET_##is_signed(name, RS_event_##name##_AT, bits)
#define RS_PACK_event(name, is_signed, bits, text) rs_bits_put(words, RS_event_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(event, RS_EVENT_FIELDS)

#define RS_POSITION_tick(name, is_signed, bits, text) \
  RS_tick_##name##_AT, RS_tick_##name##_LAST = RS_tick_##name##_AT + (bits) - 1,
#define RS_UNPACK_tick(name, is_signed, bits, text) RS_GET_##is_signed(name, RS_tick_##name##_AT, bits)
#define RS_PACK_tick(name, is_signed, bits, text) rs_bits_put(words, RS_tick_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(tick, RS_TICK_FIELDS)

#define RS_POSITION_status(name, is_signed, bits, text) \
  RS_status_##name##_AT, RS_status_##name##_LAST = RS_status_##name##_AT + (bits) - 1,
#define RS_UNPACK_status(name, is_signed, bits, text) RS_GET_##is_signed(name, RS_status_##name##_AT, bits)
#define RS_PACK_status(name, is_signed, bits, text) \
  rs_bits_put(words, RS_status_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(status, RS_STATUS_FIELDS)

#define RS_POSITION_grant(name, is_signed, bits, text) \
  RS_grant_##name##_AT, RS_grant_##name##_LAST = RS_grant_##name##_AT + (bits) - 1,
#define RS_UNPACK_grant(name, is_signed, bits, text) RS_GET_##is_signed(name, RS_grant_##name##_AT, bits)
#define RS_PACK_grant(name, is_signed, bits, text) rs_bits_put(words, RS_grant_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(grant, RS_GRANT_FIELDS)

#define RS_POSITION_joints(name, is_signed, bits, text) \
  RS_joints_##name##_AT, RS_joints_##name##_LAST = RS_joints_##name##_AT + (bits) - 1,
#define RS_UNPACK_joints(name, is_signed, bits, text) RS_GET_##is_signed(name, RS_joints_##name##_AT, bits)
#define RS_PACK_joints(name, is_signed, bits, text) \
  rs_bits_put(words, RS_joints_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(joints, RS_JOINTS_FIELDS)

#define RS_POSITION_torque(name, is_signed, bits, text) \
  RS_torque_##name##_AT, RS_torque_##name##_LAST = RS_torque_##name##_AT + (bits) - 1,
#define RS_UNPACK_torque(name, is_signed, bits, text) RS_GET_##is_signed(name, RS_torque_##name##_AT, bits)
#define RS_PACK_torque(name, is_signed, bits, text) \
  rs_bits_put(words, RS_torque_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(torque, RS_TORQUE_FIELDS)

#define RS_POSITION_topology(name, is_signed, bits, text) \
  RS_topology_##name##_AT, RS_topology_##name##_LAST = RS_topology_##name##_AT + (bits) - 1,
#define RS_UNPACK_topology(name, is_signed, bits, text) RS_GET_##is_signed(name, RS_topology_##name##_AT, bits)
#define RS_PACK_topology(name, is_signed, bits, text) \
  rs_bits_put(words, RS_topology_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(topology, RS_TOPOLOGY_FIELDS)

#define RS_POSITION_command(name, is_signed, bits, text) \
  RS_command_##name##_AT, RS_command_##name##_LAST = RS_command_##name##_AT + (bits) - 1,
#define RS_UNPACK_command(name, is_signed, bits, text) RS_GET_##is_signed(name, RS_command_##name##_AT, bits)
#define RS_PACK_command(name, is_signed, bits, text) \
  rs_bits_put(words, RS_command_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(command, RS_COMMAND_FIELDS)

#define RS_POSITION_reply(name, is_signed, bits, text) \
  RS_reply_##name##_AT, RS_reply_##name##_LAST = RS_reply_##name##_AT + (bits) - 1,
#define RS_UNPACK_reply(name, is_signed, bits, text) RS_GET_##is_signed(name, RS_reply_##name##_AT, bits)
#define RS_PACK_reply(name, is_signed, bits, text) rs_bits_put(words, RS_reply_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(reply, RS_REPLY_FIELDS)

#define RS_POSITION_join(name, is_signed, bits, text) \
  RS_join_##name##_AT, RS_join_##name##_LAST = RS_join_##name##_AT + (bits) - 1,
#define RS_UNPACK_join(name, is_signed, bits, text) RS_GET_##is_signed(name, RS_join_##name##_AT, bits)
#define RS_PACK_join(name, is_signed, bits, text) rs_bits_put(words, RS_join_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(join, RS_JOIN_FIELDS)

#define RS_POSITION_further(name, is_signed, bits, text) \
  RS_further_##name##_AT, RS_further_##name##_LAST = RS_further_##name##_AT + (bits) - 1,
#define RS_UNPACK_further(name, is_signed, bits, text) RS_GET_##is_signed(name, RS_further_##name##_AT, bits)
#define RS_PACK_further(name, is_signed, bits, text) \
  rs_bits_put(words, RS_further_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(further, RS_FURTHER_FIELDS)

#define RS_POSITION_key(name, is_signed, bits, text) \
  RS_key_##name##_AT, RS_key_##name##_LAST = RS_key_##name##_AT + (bits) - 1,
#define RS_UNPACK_key(name, is_signed, bits, text) RS_GET_##is_signed(name, RS_key_##name##_AT, bits)
#define RS_PACK_key(name, is_signed, bits, text) rs_bits_put(words, RS_key_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(key, RS_KEY_FIELDS)

/* The largest number that an unsigned field holds, by frame and field: RS_FIELD_MAX(tick_age_4us). */
#define RS_FIELD_MAX(field) ((1U << ((unsigned)RS_##field##_LAST - (unsigned)RS_##field##_AT + 1U)) - 1U)

#ifdef __cplusplus
}
#endif

#endif
