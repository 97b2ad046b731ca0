/* What the parts of the section unit offer each other. */
#ifndef ROBOTSKIN_SECTION_UNIT_UNIT_PARTS_H
#define ROBOTSKIN_SECTION_UNIT_UNIT_PARTS_H

#include "cell/parts.h"
#include "robotskin/section_unit.h"

/* ---- names.c ---- */
void rs_names_init(rs_unit_names* names, const rs_section_unit_config* config);
/* The id for a cell that asks and would like `wanted`; RS_ID_NONE if there is none left. */
uint16_t rs_names_give(rs_unit_names* names, const rs_section_unit_config* config, uint32_t uid, uint16_t wanted);
/* Takes note of a named cell; false if its id belongs to another, so that it has to ask anew. */
bool rs_names_agree(rs_unit_names* names, const rs_section_unit_config* config, uint32_t uid, uint16_t id);

/* ---- ports.c: ports are indices 0 to 14 ---- */
void rs_ports_tick(rs_section_unit* unit, uint64_t now_ns);
void rs_ports_receive(rs_section_unit* unit, unsigned port, const uint8_t* frame, uint64_t now_ns);
void rs_ports_transmit(rs_section_unit* unit, uint64_t now_ns, rs_unit_output* output);
void rs_ports_power(rs_section_unit* unit, unsigned port, bool on);
void rs_ports_pack_tick(const rs_section_unit* unit, unsigned port, uint64_t now_ns, uint8_t* frame);
bool rs_port_alive(const rs_unit_port* port, uint64_t now_ns);
/* Puts a command or another downward frame into a port's queue; commands get their tag. */
void rs_ports_send(rs_section_unit* unit, unsigned port, const uint8_t* content);

/* ---- trees.c: all trees of the group, own and heard of ---- */
enum { RS_TREES_MAX = RS_UNITS_MAX * RS_SECTION_UNIT_PORTS_MAX, RS_TREE_WORDS = (RS_TREES_MAX + 31) / 32 };
typedef struct {
  unsigned count;
  uint8_t root[RS_TREES_MAX];
  uint8_t port[RS_TREES_MAX]; /* own: index, else RS_TREE_FOREIGN */
  uint16_t size[RS_TREES_MAX];
  uint8_t height[RS_TREES_MAX]; /* hops of the deepest cell */
  uint8_t depth_cap[RS_TREES_MAX];
  uint8_t component[RS_TREES_MAX];              /* smallest index of those it hangs together with */
  uint32_t beside[RS_TREES_MAX][RS_TREE_WORDS]; /* bit j: tree j is beside it */
} rs_trees;
enum { RS_TREE_FOREIGN = 255, RS_POTENTIAL_SCALE = 1024 };
uint8_t rs_root_of(const rs_section_unit* unit, unsigned port);
void rs_trees_gather(rs_trees* trees, const rs_section_unit* unit, uint64_t now_ns);
bool rs_trees_beside(const rs_trees* trees, unsigned a, unsigned b);
/* Brings the potentials nearer to where their differences along neighbouring trees are the flows that level all. */
void rs_trees_relax(const rs_trees* trees, int64_t potential[256]);

/* ---- forming.c ---- */
/* Once a tick: `unit->forming` until the sizes of the trees stay as they are. */
void rs_forming_tick(rs_section_unit* unit, uint64_t now_ns);

/* ---- wants.c: how many cells a tree is to give, and to whom ---- */
enum {
  RS_OFFER_TICKS = 3,  /* without a further offer, and while the tree is crossed, a round is over */
  RS_FAILED_ROUNDS = 2 /* without an offer, after which a tree is taken for one that gives nothing */
};
/* Down and up a tree so deep takes about so many ticks. */
RS_INLINE uint64_t rs_there_and_back(const rs_unit_port* port) {
  return (3U * (uint32_t)port->height) / 8U;
}
/* Opens a round of own tree k, in whose component are so many cells and trees, if it has anything to give; `lead` keeps
 * the record of the component. */
void rs_wants_start(rs_section_unit* unit, const rs_trees* trees, unsigned k, uint32_t cells, uint32_t count,
                    const rs_unit_balance* lead);
void rs_want_remove(rs_unit_balance* balance, unsigned w);
void rs_wants_close(rs_unit_balance* balance);

/* ---- depth_cap.c: how deep balance may make the trees ---- */
enum { RS_STALLED_ROUNDS = 8 }; /* without progress, after which the cap is raised */
/* Sees whether a component with own trees has come nearer to level, and raises its cap if it has not for long. `first`
 * is the component's first tree, `lead` the port that keeps its record. */
void rs_depth_cap_watch(rs_section_unit* unit, const rs_trees* trees, unsigned first, rs_unit_balance* lead);

/* ---- balance.c: rounds of offers and grants ---- */
void rs_balance_tick(rs_section_unit* unit, uint64_t now_ns);
void rs_balance_status(rs_section_unit* unit, unsigned port, const rs_status* status);
/* The own trees as records of a datagram; how many. */
uint32_t rs_balance_pack(const rs_section_unit* unit, uint8_t* records, uint64_t now_ns);

/* ---- rate.c ---- */
void rs_rate_start(rs_unit_rate* rate);
/* Notes a frame that came up. */
void rs_rate_heard(rs_unit_rate* rate, const uint8_t* frame);
/* The host may have changed the cells' rate: the highest one is assumed until it is measured. */
void rs_rate_forget(rs_unit_rate* rate);
/* Once a millisecond; true if the divisor has changed. */
bool rs_rate_tick(rs_unit_rate* rate, uint32_t size);

/* ---- torque.c ---- */
void rs_unit_torque_tick(rs_section_unit* unit, uint64_t now_ns);
void rs_unit_torque_receive(rs_section_unit* unit, unsigned port, const uint8_t* frame, uint64_t now_ns);
/* Hands over what is due; when the next is. */
uint64_t rs_unit_torque_end(rs_section_unit* unit, uint64_t now_ns);

/* ---- datagrams.c ---- */
/* `port` is counted from 1 here, 0: the unit itself. */
void rs_datagrams_gather(rs_section_unit* unit, unsigned port, const uint8_t* frame, uint64_t now_ns);
void rs_datagrams_receive(rs_section_unit* unit, const uint8_t* bytes, uint32_t count, uint64_t now_ns);
/* Writes at most one datagram; returns when the next one is due, if nothing comes before. */
uint64_t rs_datagrams_send(rs_section_unit* unit, uint64_t now_ns, rs_unit_output* output);
/* Completes the datagram whose `count` records stand in place already. */
void rs_datagram_finish(rs_section_unit* unit, rs_datagram_kind kind, uint32_t count, uint64_t now_ns,
                        rs_unit_output* output);

/* ---- peers.c: the other units of the group ---- */
uint64_t rs_unit_time(const rs_section_unit* unit, uint64_t now_ns); /* the group's time at an own time */
void rs_peers_keep_time(rs_section_unit* unit, uint64_t now_ns);     /* once a tick */
bool rs_peer_counts(const rs_unit_peer* peer, uint64_t now_ns);      /* both hear each other */
/* As rs_datagrams_send. */
uint64_t rs_peers_send(rs_section_unit* unit, uint64_t now_ns, rs_unit_output* output);
/* A datagram whose tag is right; false if it is of no use. */
bool rs_peers_receive(rs_section_unit* unit, const rs_datagram_header* header, const uint8_t* bytes, uint64_t now_ns);

#endif
