#include "cell/parts.h"

void rs_subtree_update(rs_cell* cell) {
  rs_route* route = &cell->route;
  uint32_t size = 1, lean_size = 1, height = 0;
  bool alternative = false;
  uint8_t foreign_root = 0;
  for (unsigned port = 0; port < RS_PORTS; ++port) {
    const rs_neighbour* neighbour = &route->neighbour[port];
    if (port + 1U == route->parent_port) continue;
    if (neighbour->child && neighbour->up) {
      size += neighbour->size;
      if (!neighbour->alternative) lean_size += neighbour->lean_size;
      if (neighbour->height >= height) height = neighbour->height + 1U;
    } else if (rs_link_usable(neighbour) && neighbour->hops < RS_HOPS_POISON) {
      if (neighbour->wave.root != route->wave.root) {
        foreign_root = neighbour->wave.root;
      } else if (neighbour->hops < route->hops && !neighbour->leaving) {
        alternative = true;
      }
    }
  }
  if (size > 0xFFFFU) size = 0xFFFFU;
  if (lean_size > 0xFFFFU) lean_size = 0xFFFFU;
  if (height > 0xFFU) height = 0xFFU;
  if (size != route->subtree_size || height != route->subtree_height) cell->queues.status_due = true;
  route->subtree_size = (uint16_t)size;
  route->subtree_lean_size = (uint16_t)lean_size;
  route->subtree_height = (uint8_t)height;
  route->alternative = alternative;
  route->foreign_root = foreign_root;
}

void rs_subtree_status(rs_cell* cell, unsigned port, const uint8_t* frame) {
  rs_neighbour* neighbour = &cell->route.neighbour[port];
  rs_status status;
  rs_status_unpack(&status, frame);
  neighbour->size = (uint16_t)status.size;
  neighbour->lean_size = (uint16_t)status.lean_size;
  neighbour->height = (uint8_t)status.height;
  neighbour->alternative = status.alternative != 0U;
  rs_subtree_update(cell);
}

void rs_subtree_pack(const rs_cell* cell, uint8_t* frame) {
  const rs_route* route = &cell->route;
  const rs_status status = {.type = RS_TYPE_status,
                            .sender = cell->id,
                            .size = route->subtree_size,
                            .lean_size = route->subtree_lean_size,
                            .height = route->subtree_height,
                            .alternative = route->alternative,
                            .foreign_root = route->foreign_root,
                            .tick_echo = route->wave.sequence & 0xFFU};
  rs_status_pack(frame, &status);
  rs_frame_seal(frame);
}
