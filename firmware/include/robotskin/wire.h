/* The wire format between cells: the only place where a frame is laid out.
 *
 * A frame is 20 bytes: 144 bits of content, most significant bit first, then a 16-bit checksum (crc.h). Links carry
 * nothing but frames, so a receiver finds their boundaries by the checksum and needs no delimiter.
 * Every frame is a list of fields X(name, signed, bits); from it come the struct `rs_NAME`, the functions
 * `rs_NAME_pack` and `rs_NAME_unpack`, the bit table in docs/protocol.md and the Python bindings. */
#ifndef ROBOTSKIN_WIRE_H
#define ROBOTSKIN_WIRE_H

#include <stdint.h>

#include "robotskin/channels.h"
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
  RS_LINK_BAUD = 4000000,
  RS_LINK_BITS_PER_BYTE = 10, /* 8N1 */
  RS_CELLS_PER_PORT = 66,     /* at 250 Hz: 82.5 % of 80 */
  RS_JOINTS_PER_PART = 6
};

/* X(name, number, who sends it to whom) */
#define RS_FRAME_TYPES(X)                                                        \
  X(clock, 1, "cell to host: one sample, at the clock rate")                     \
  X(event, 2, "cell to host: one sample, because a channel changed")             \
  X(tick, 3, "to every neighbour: heartbeat, route advert, clock")               \
  X(status, 4, "cell to parent: its subtree, and offers for balance")            \
  X(grant, 5, "section unit to its tree: wants, and leave for one cell to move") \
  X(joints, 6, "host to all cells: joint positions of one epoch")                \
  X(torque, 7, "cell to parent: summed joint torques of one epoch")              \
  X(topology, 8, "cell to host: identity and port-to-port neighbours")           \
  X(command, 9, "host to one cell or all")                                       \
  X(reply, 10, "cell to host: answer to a command")                              \
  X(join, 11, "cell to section unit: a cell without an id asks for one")

#define RS_TYPE_NUMBER(name, number, text) RS_TYPE_##name = (number),
typedef enum { RS_FRAME_TYPES(RS_TYPE_NUMBER) RS_TYPE_LIMIT = 16 } rs_frame_type;
#undef RS_TYPE_NUMBER

/* The sample time is the low bits of the tick number and the elapsed 64ths of the tick period. */
#define RS_SAMPLE_FIELDS(X)                                                                                     \
  X(type, 0, 4)                                                                                                 \
  X(source, 0, 14) X(sequence, 0, 8) X(ttl, 0, 6) X(sample_tick, 0, 4) X(sample_phase, 0, 6) X(refresh, 0, 1)   \
      X(fault, 0, 1) X(replayed, 0, 1) X(dropped, 0, 1) X(proximity, 0, 16) X(force_1, 0, 10) X(force_2, 0, 10) \
          X(force_3, 0, 10) X(acceleration_x, 1, 10) X(acceleration_y, 1, 10) X(acceleration_z, 1, 10)          \
              X(temperature_1, 1, 8) X(temperature_2, 1, 14)

#define RS_CLOCK_FIELDS(X) RS_SAMPLE_FIELDS(X)
#define RS_EVENT_FIELDS(X) RS_SAMPLE_FIELDS(X)

/* The tag covers what the root fixed (sequence, root, depth cap, rate divisor, gain threshold), not what each hop
 * changes. */
#define RS_TICK_FIELDS(X)                                                                                             \
  X(type, 0, 4)                                                                                                       \
  X(sequence, 0, 16) X(hops, 0, 8) X(root, 0, 8) X(sender, 0, 14) X(sender_port, 0, 2) X(nonce, 0, 8) X(parent, 0, 1) \
      X(heard, 0, 1) X(leaving, 0, 1) X(forming, 0, 1) X(depth_cap, 0, 8) X(rate_divisor, 0, 4)                       \
          X(gain_threshold, 0, 6) X(echo, 0, 8) X(age_us, 0, 12) X(spare, 0, 10) X(tag, 0, 32)

#define RS_STATUS_FIELDS(X)                                                                                         \
  X(type, 0, 4)                                                                                                     \
  X(sender, 0, 14) X(size, 0, 16) X(lean_size, 0, 16) X(height, 0, 8) X(alternative, 0, 1) X(candidate, 0, 14)      \
      X(candidate_size, 0, 16) X(candidate_delta, 0, 4) X(candidate_root, 0, 8) X(foreign_root, 0, 8) X(echo, 0, 8) \
          X(tick_echo, 0, 8) X(spare, 0, 19)

#define RS_GRANT_FIELDS(X)                                                                                        \
  X(type, 0, 4)                                                                                                   \
  X(sequence, 0, 16) X(root, 0, 8) X(cell, 0, 14) X(target_root, 0, 8) X(want_1_root, 0, 8) X(want_1_size, 0, 16) \
      X(want_2_root, 0, 8) X(want_2_size, 0, 16) X(depth_cap, 0, 8) X(gain_threshold, 0, 6) X(tag, 0, 32)

#define RS_JOINTS_FIELDS(X)                                                                                          \
  X(type, 0, 4)                                                                                                      \
  X(epoch, 0, 6) X(limb, 0, 4) X(part, 0, 2) X(joint_1, 1, 16) X(joint_2, 1, 16) X(joint_3, 1, 16) X(joint_4, 1, 16) \
      X(joint_5, 1, 16) X(joint_6, 1, 16) X(spare, 0, 8) X(tag, 0, 24)

#define RS_TORQUE_FIELDS(X)                                                                                          \
  X(type, 0, 4)                                                                                                      \
  X(epoch, 0, 6) X(limb, 0, 4) X(part, 0, 2) X(joint_1, 1, 16) X(joint_2, 1, 16) X(joint_3, 1, 16) X(joint_4, 1, 16) \
      X(joint_5, 1, 16) X(joint_6, 1, 16) X(cells, 0, 14) X(active, 0, 12) X(age, 0, 4) X(saturated, 0, 1)           \
          X(spare, 0, 1)

/* Ports are stored as port - 1; errors_p is the binary logarithm of the frames lost on that port, capped at 7. */
#define RS_TOPOLOGY_FIELDS(X)                                                                                       \
  X(type, 0, 4)                                                                                                     \
  X(source, 0, 14) X(uid, 0, 32) X(revision, 0, 6) X(parent_port, 0, 3) X(spare, 0, 9) X(neighbour_1, 0, 14)        \
      X(neighbour_port_1, 0, 2) X(errors_1, 0, 3) X(neighbour_2, 0, 14) X(neighbour_port_2, 0, 2) X(errors_2, 0, 3) \
          X(neighbour_3, 0, 14) X(neighbour_port_3, 0, 2) X(errors_3, 0, 3) X(neighbour_4, 0, 14)                   \
              X(neighbour_port_4, 0, 2) X(errors_4, 0, 3)

#define RS_COMMAND_FIELDS(X)                                                                                     \
  X(type, 0, 4)                                                                                                  \
  X(target, 0, 14) X(operation, 0, 6) X(counter, 0, 16) X(index, 0, 16) X(value_high, 0, 16) X(value_low, 0, 32) \
      X(spare, 0, 8) X(tag, 0, 32)

#define RS_REPLY_FIELDS(X)                                                                           \
  X(type, 0, 4)                                                                                      \
  X(source, 0, 14) X(ttl, 0, 6) X(operation, 0, 6) X(counter, 0, 16) X(status, 0, 4) X(index, 0, 16) \
      X(value_high, 0, 16) X(value_low, 0, 32) X(spare, 0, 30)

#define RS_JOIN_FIELDS(X) \
  X(type, 0, 4)           \
  X(uid, 0, 32) X(ttl, 0, 6) X(nonce, 0, 8) X(sender, 0, 14) X(spare_1, 0, 16) X(spare_2, 0, 32) X(spare_3, 0, 32)

RS_INLINE uint32_t rs_bits_get(const uint32_t* words, unsigned at, unsigned width) {
  const unsigned word = at / 32U, bit = at % 32U;
  const uint32_t mask = width == 32U ? 0xFFFFFFFFU : (1U << width) - 1U;
  if (bit + width <= 32U) return (words[word] >> (32U - bit - width)) & mask;
  const unsigned low = bit + width - 32U;
  return ((words[word] << low) | (words[word + 1U] >> (32U - low))) & mask;
}

RS_INLINE void rs_bits_put(uint32_t* words, unsigned at, unsigned width, uint32_t value) {
  const unsigned word = at / 32U, bit = at % 32U;
  if (width < 32U) value &= (1U << width) - 1U;
  if (bit + width <= 32U) {
    words[word] |= value << (32U - bit - width);
  } else {
    const unsigned low = bit + width - 32U;
    words[word] |= value >> low;
    words[word + 1U] |= value << (32U - low);
  }
}

RS_INLINE int32_t rs_sign_extend(uint32_t value, unsigned width) {
  const uint32_t sign = 1U << (width - 1U);
  return (int32_t)((value ^ sign) - sign);
}

RS_INLINE uint32_t rs_load32(const uint8_t* bytes) {
  return ((uint32_t)bytes[0] << 24) | ((uint32_t)bytes[1] << 16) | ((uint32_t)bytes[2] << 8) | (uint32_t)bytes[3];
}

RS_INLINE void rs_store32(uint8_t* bytes, uint32_t word) {
  bytes[0] = (uint8_t)(word >> 24);
  bytes[1] = (uint8_t)(word >> 16);
  bytes[2] = (uint8_t)(word >> 8);
  bytes[3] = (uint8_t)word;
}

/* The content as big-endian words; the last word holds 16 content bits on top and is zero below. */
RS_INLINE void rs_content_load(uint32_t words[5], const uint8_t* bytes) {
  for (unsigned i = 0; i < 4U; ++i) words[i] = rs_load32(bytes + 4U * i);
  words[4] = ((uint32_t)bytes[16] << 24) | ((uint32_t)bytes[17] << 16);
}

RS_INLINE void rs_content_store(uint8_t* bytes, const uint32_t words[5]) {
  for (unsigned i = 0; i < 4U; ++i) rs_store32(bytes + 4U * i, words[i]);
  bytes[16] = (uint8_t)(words[4] >> 24);
  bytes[17] = (uint8_t)(words[4] >> 16);
}

RS_INLINE rs_frame_type rs_frame_type_of(const uint8_t* bytes) {
  return (rs_frame_type)(bytes[0] >> 4);
}

#define RS_MEMBER_0(name) uint32_t name;
#define RS_MEMBER_1(name) int32_t name;
#define RS_MEMBER(name, is_signed, bits) RS_MEMBER_##is_signed(name)
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

#define RS_POSITION_clock(name, is_signed, bits) \
  RS_clock_##name##_AT, RS_clock_##name##_LAST = RS_clock_##name##_AT + (bits) - 1,
#define RS_UNPACK_clock(name, is_signed, bits) RS_GET_##is_signed(name, RS_clock_##name##_AT, bits)
#define RS_PACK_clock(name, is_signed, bits) rs_bits_put(words, RS_clock_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(clock, RS_CLOCK_FIELDS)

#define RS_POSITION_event(name, is_signed, bits) \
  RS_event_##name##_AT, RS_event_##name##_LAST = RS_event_##name##_AT + (bits) - 1,
#define RS_UNPACK_event(name, is_signed, bits) RS_GET_##is_signed(name, RS_event_##name##_AT, bits)
#define RS_PACK_event(name, is_signed, bits) rs_bits_put(words, RS_event_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(event, RS_EVENT_FIELDS)

#define RS_POSITION_tick(name, is_signed, bits) \
  RS_tick_##name##_AT, RS_tick_##name##_LAST = RS_tick_##name##_AT + (bits) - 1,
#define RS_UNPACK_tick(name, is_signed, bits) RS_GET_##is_signed(name, RS_tick_##name##_AT, bits)
#define RS_PACK_tick(name, is_signed, bits) rs_bits_put(words, RS_tick_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(tick, RS_TICK_FIELDS)

#define RS_POSITION_status(name, is_signed, bits) \
  RS_status_##name##_AT, RS_status_##name##_LAST = RS_status_##name##_AT + (bits) - 1,
#define RS_UNPACK_status(name, is_signed, bits) RS_GET_##is_signed(name, RS_status_##name##_AT, bits)
#define RS_PACK_status(name, is_signed, bits) rs_bits_put(words, RS_status_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(status, RS_STATUS_FIELDS)

#define RS_POSITION_grant(name, is_signed, bits) \
  RS_grant_##name##_AT, RS_grant_##name##_LAST = RS_grant_##name##_AT + (bits) - 1,
#define RS_UNPACK_grant(name, is_signed, bits) RS_GET_##is_signed(name, RS_grant_##name##_AT, bits)
#define RS_PACK_grant(name, is_signed, bits) rs_bits_put(words, RS_grant_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(grant, RS_GRANT_FIELDS)

#define RS_POSITION_joints(name, is_signed, bits) \
  RS_joints_##name##_AT, RS_joints_##name##_LAST = RS_joints_##name##_AT + (bits) - 1,
#define RS_UNPACK_joints(name, is_signed, bits) RS_GET_##is_signed(name, RS_joints_##name##_AT, bits)
#define RS_PACK_joints(name, is_signed, bits) rs_bits_put(words, RS_joints_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(joints, RS_JOINTS_FIELDS)

#define RS_POSITION_torque(name, is_signed, bits) \
  RS_torque_##name##_AT, RS_torque_##name##_LAST = RS_torque_##name##_AT + (bits) - 1,
#define RS_UNPACK_torque(name, is_signed, bits) RS_GET_##is_signed(name, RS_torque_##name##_AT, bits)
#define RS_PACK_torque(name, is_signed, bits) rs_bits_put(words, RS_torque_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(torque, RS_TORQUE_FIELDS)

#define RS_POSITION_topology(name, is_signed, bits) \
  RS_topology_##name##_AT, RS_topology_##name##_LAST = RS_topology_##name##_AT + (bits) - 1,
#define RS_UNPACK_topology(name, is_signed, bits) RS_GET_##is_signed(name, RS_topology_##name##_AT, bits)
#define RS_PACK_topology(name, is_signed, bits) rs_bits_put(words, RS_topology_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(topology, RS_TOPOLOGY_FIELDS)

#define RS_POSITION_command(name, is_signed, bits) \
  RS_command_##name##_AT, RS_command_##name##_LAST = RS_command_##name##_AT + (bits) - 1,
#define RS_UNPACK_command(name, is_signed, bits) RS_GET_##is_signed(name, RS_command_##name##_AT, bits)
#define RS_PACK_command(name, is_signed, bits) rs_bits_put(words, RS_command_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(command, RS_COMMAND_FIELDS)

#define RS_POSITION_reply(name, is_signed, bits) \
  RS_reply_##name##_AT, RS_reply_##name##_LAST = RS_reply_##name##_AT + (bits) - 1,
#define RS_UNPACK_reply(name, is_signed, bits) RS_GET_##is_signed(name, RS_reply_##name##_AT, bits)
#define RS_PACK_reply(name, is_signed, bits) rs_bits_put(words, RS_reply_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(reply, RS_REPLY_FIELDS)

#define RS_POSITION_join(name, is_signed, bits) \
  RS_join_##name##_AT, RS_join_##name##_LAST = RS_join_##name##_AT + (bits) - 1,
#define RS_UNPACK_join(name, is_signed, bits) RS_GET_##is_signed(name, RS_join_##name##_AT, bits)
#define RS_PACK_join(name, is_signed, bits) rs_bits_put(words, RS_join_##name##_AT, (bits), (uint32_t)in->name);
RS_DEFINE_FRAME(join, RS_JOIN_FIELDS)

#ifdef __cplusplus
}
#endif

#endif
