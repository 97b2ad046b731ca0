/* SPDX-License-Identifier: Apache-2.0
 * The wire format between section unit and host, and between section units: one UDP datagram, numbers big-endian.
 *
 * header (36 bytes) | count records of 20 bytes | tag (16 bytes, only if RS_DATAGRAM_KEYED is set)
 *
 * A record is the 18 content bytes of a frame (wire.h) and 16 bits: the section unit's port (4 bits, 1 to 15, 0 for
 * the unit itself; downwards a frame goes out on that port, on all ports for 0) and, upwards, how long before
 * `time_ns` the frame arrived, in microseconds (12 bits).
 * The tag is the first 16 bytes of keyed BLAKE2s-256 over all bytes before it. `session` is drawn at each start of a
 * sender (never 0) and `sequence` grows by one with each of its datagrams, so a datagram cannot be played again within
 * a session. `answering` is the session last heard from the other end, so one of an earlier session cannot either: an
 * end that has a key drops what does not answer its own session, except that a section unit listens to a `keep_alive`
 * with `answering` 0, which opens the exchange. */
#ifndef ROBOTSKIN_DATAGRAM_H
#define ROBOTSKIN_DATAGRAM_H

#include <stdint.h>

#include "robotskin/wire.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  RS_DATAGRAM_MAGIC = 0x52534B4E, /* "RSKN" */
  RS_DATAGRAM_VERSION = 1,
  RS_DATAGRAM_VERSION_BYTES = 5, /* of the answer to another version */
  RS_DATAGRAM_HEADER_BYTES = 36,
  RS_DATAGRAM_RECORD_BYTES = RS_CONTENT_BYTES + 2,
  RS_DATAGRAM_TAG_BYTES = 16,
  RS_DATAGRAM_KEY_BYTES = 32,
  RS_DATAGRAM_BYTES_MAX = 1472, /* Ethernet without fragmentation */
  RS_DATAGRAM_RECORDS_MAX = (RS_DATAGRAM_BYTES_MAX - RS_DATAGRAM_HEADER_BYTES - RS_DATAGRAM_TAG_BYTES) /
      RS_DATAGRAM_RECORD_BYTES,
  RS_DATAGRAM_KEYED = 1, /* flag: a tag follows the records */
  RS_SECTION_UNIT_PORTS_MAX = 15,
  RS_UNIT_ALL = 255,           /* down: every section unit of the group */
  RS_HOST_PORT = 1337,         /* UDP port of the host, as of the published interface boxes */
  RS_SECTION_UNIT_PORT = 1336, /* UDP port of a section unit */
  RS_KEEP_ALIVE_MS = 100
};

/* X(name, number, direction and meaning) */
#define RS_DATAGRAM_KINDS(X)                                                                  \
  X(frames, 1, "up: frames that arrived at the section unit's ports")                         \
  X(heartbeat, 2, "up: nothing to report; records are the unit's own status frames")          \
  X(keep_alive, 3, "down: the host listens; without it a section unit falls silent")          \
  X(inject, 4, "down: frames (command, joints) to send into the network; the unit tags them") \
  X(power, 5, "down: a record's first byte switches its port (0: all) on (1) or off (0)")     \
  X(peer, 6, "between the units of a group: time, trees, and which hears which")

#define RS_DATAGRAM_KIND_NUMBER(name, number, text) RS_DATAGRAM_KIND_##name = (number),
typedef enum { RS_DATAGRAM_KINDS(RS_DATAGRAM_KIND_NUMBER) RS_DATAGRAM_KIND_LIMIT } rs_datagram_kind;
#undef RS_DATAGRAM_KIND_NUMBER

typedef struct {
  uint8_t kind;
  uint8_t flags;
  uint8_t unit;   /* physical section unit within its group */
  uint16_t group; /* of section units: the name space of cell ids */
  uint32_t session;
  uint32_t sequence;
  uint64_t time_ns;   /* sender's clock when the datagram left */
  uint16_t count;     /* records */
  uint32_t dropped;   /* frames the section unit had to drop since its start */
  uint32_t answering; /* session of the other end, 0: not heard yet */
} rs_datagram_header;

/* Byte positions: magic 0, version 4, kind 5, group 6, session 8, sequence 12, time_ns 16, count 24, unit 26,
 * flags 27, dropped 28, answering 32. */
RS_INLINE void rs_datagram_header_pack(uint8_t* bytes, const rs_datagram_header* in) {
  rs_store32(bytes, (uint32_t)RS_DATAGRAM_MAGIC);
  bytes[4] = RS_DATAGRAM_VERSION;
  bytes[5] = in->kind;
  bytes[6] = (uint8_t)(in->group >> 8);
  bytes[7] = (uint8_t)in->group;
  rs_store32(bytes + 8, in->session);
  rs_store32(bytes + 12, in->sequence);
  rs_store32(bytes + 16, (uint32_t)(in->time_ns >> 32));
  rs_store32(bytes + 20, (uint32_t)in->time_ns);
  bytes[24] = (uint8_t)(in->count >> 8);
  bytes[25] = (uint8_t)in->count;
  bytes[26] = in->unit;
  bytes[27] = in->flags;
  rs_store32(bytes + 28, in->dropped);
  rs_store32(bytes + 32, in->answering);
}

/* Magic and version alone: what a section unit answers to a datagram of another version, keyed or not. */
RS_INLINE void rs_datagram_version_pack(uint8_t* bytes) {
  rs_store32(bytes, (uint32_t)RS_DATAGRAM_MAGIC);
  bytes[4] = RS_DATAGRAM_VERSION;
}

typedef enum {
  RS_DATAGRAM_OK = 0,
  RS_DATAGRAM_TOO_SHORT,
  RS_DATAGRAM_FOREIGN, /* wrong magic */
  RS_DATAGRAM_VERSION_ALIEN,
  RS_DATAGRAM_KIND_UNKNOWN,
  RS_DATAGRAM_LENGTH_WRONG /* length and count disagree */
} rs_datagram_fault;

/* Reads the header and checks that the length is exactly what header, records and tag need. */
RS_INLINE rs_datagram_fault rs_datagram_header_unpack(rs_datagram_header* out, const uint8_t* bytes, uint32_t length) {
  if (length < (uint32_t)RS_DATAGRAM_HEADER_BYTES) return RS_DATAGRAM_TOO_SHORT;
  if (rs_load32(bytes) != (uint32_t)RS_DATAGRAM_MAGIC) return RS_DATAGRAM_FOREIGN;
  if (bytes[4] != RS_DATAGRAM_VERSION) return RS_DATAGRAM_VERSION_ALIEN;
  out->kind = bytes[5];
  out->group = (uint16_t)(((uint32_t)bytes[6] << 8) | bytes[7]);
  out->session = rs_load32(bytes + 8);
  out->sequence = rs_load32(bytes + 12);
  out->time_ns = ((uint64_t)rs_load32(bytes + 16) << 32) | rs_load32(bytes + 20);
  out->count = (uint16_t)(((uint32_t)bytes[24] << 8) | bytes[25]);
  out->unit = bytes[26];
  out->flags = bytes[27];
  out->dropped = rs_load32(bytes + 28);
  out->answering = rs_load32(bytes + 32);
  if (out->kind == 0 || out->kind >= RS_DATAGRAM_KIND_LIMIT) return RS_DATAGRAM_KIND_UNKNOWN;
  const uint32_t tag = (out->flags & RS_DATAGRAM_KEYED) != 0 ? (uint32_t)RS_DATAGRAM_TAG_BYTES : 0U;
  if (out->count > RS_DATAGRAM_RECORDS_MAX ||
      length != (uint32_t)RS_DATAGRAM_HEADER_BYTES + (uint32_t)RS_DATAGRAM_RECORD_BYTES * out->count + tag) {
    return RS_DATAGRAM_LENGTH_WRONG;
  }
  return RS_DATAGRAM_OK;
}

/* The two bytes after a record's frame content. */
RS_INLINE void rs_record_arrival_pack(uint8_t* record, uint32_t port, uint32_t age_us) {
  const uint32_t word = ((port & 0xFU) << 12) | (age_us > 0xFFFU ? 0xFFFU : age_us);
  record[RS_CONTENT_BYTES] = (uint8_t)(word >> 8);
  record[RS_CONTENT_BYTES + 1] = (uint8_t)word;
}

RS_INLINE uint32_t rs_record_port(const uint8_t* record) {
  return record[RS_CONTENT_BYTES] >> 4;
}

RS_INLINE uint32_t rs_record_age_us(const uint8_t* record) {
  return ((uint32_t)(record[RS_CONTENT_BYTES] & 0xFU) << 8) | record[RS_CONTENT_BYTES + 1];
}

/* ---- Records of a `peer` datagram ----
 * Its first record, of port 0, is the sender itself; the other records of port 0 are the units it hears; a record of
 * port p is the tree there. A unit counts another one as its peer while that one says that it hears the unit's session:
 * so links that carry one way only, and datagrams of earlier sessions, do not count. Clocks are compared by echo, as in
 * the Network Time Protocol: half the round trip is the way. */
enum {
  RS_PEER_NEIGHBOURS = 14,
  RS_PEER_STARTING = 1, /* flag: has not yet ticked long enough to lead */
  RS_PEER_FORMING = 2   /* flag: its trees are being formed */
};

typedef struct {
  uint8_t unit;
  uint8_t flags;    /* of the sender itself */
  uint32_t session; /* of that unit, as heard */
  uint32_t sent_ns; /* that unit's own clock, low 32 bits, when its last datagram left */
  uint32_t held_ns; /* from its arrival to this datagram; 0 for the sender itself */
} rs_peer_unit;

typedef struct {
  uint16_t size;
  uint8_t height;                        /* hops to the deepest cell, from the port */
  uint8_t depth_cap;                     /* deepest hops a move may reach */
  uint8_t neighbour[RS_PEER_NEIGHBOURS]; /* roots of trees beside it; 0: none */
} rs_peer_tree;

/* Byte positions: unit 0, flags 1, session 2, sent_ns 6, held_ns 10. */
RS_INLINE void rs_peer_unit_pack(uint8_t* record, const rs_peer_unit* in) {
  for (unsigned i = 0; i < RS_DATAGRAM_RECORD_BYTES; ++i) record[i] = 0;
  record[0] = in->unit;
  record[1] = in->flags;
  rs_store32(record + 2, in->session);
  rs_store32(record + 6, in->sent_ns);
  rs_store32(record + 10, in->held_ns);
}

RS_INLINE void rs_peer_unit_unpack(rs_peer_unit* out, const uint8_t* record) {
  out->unit = record[0];
  out->flags = record[1];
  out->session = rs_load32(record + 2);
  out->sent_ns = rs_load32(record + 6);
  out->held_ns = rs_load32(record + 10);
}

/* Byte positions: size 0, height 2, depth_cap 3, neighbour 4 to 17. */
RS_INLINE void rs_peer_tree_pack(uint8_t* record, uint32_t port, const rs_peer_tree* in) {
  record[0] = (uint8_t)(in->size >> 8);
  record[1] = (uint8_t)in->size;
  record[2] = in->height;
  record[3] = in->depth_cap;
  for (unsigned i = 0; i < RS_PEER_NEIGHBOURS; ++i) record[4U + i] = in->neighbour[i];
  rs_record_arrival_pack(record, port, 0);
}

RS_INLINE void rs_peer_tree_unpack(rs_peer_tree* out, const uint8_t* record) {
  out->size = (uint16_t)(((uint32_t)record[0] << 8) | record[1]);
  out->height = record[2];
  out->depth_cap = record[3];
  for (unsigned i = 0; i < RS_PEER_NEIGHBOURS; ++i) out->neighbour[i] = record[4U + i];
}

#ifdef __cplusplus
}
#endif

#endif
