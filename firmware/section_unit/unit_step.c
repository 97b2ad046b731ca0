/* SPDX-License-Identifier: Apache-2.0
 * The front door of a section unit: one input at one time, and what is due. */
#include <stddef.h>
#include <string.h>

#include "section_unit/datagrams.h"
#include "section_unit/id_allocator.h"
#include "section_unit/peers.h"
#include "section_unit/port.h"
#include "section_unit/ports.h"
#include "section_unit/rate.h"
#include "section_unit/torque.h"

static bool valid(const rs_section_unit_config* config) {
  return config->ports >= 1U && config->ports <= RS_SECTION_UNIT_PORTS_MAX && config->unit <= 15U &&
         config->first_id >= RS_ID_FIRST && config->first_id <= config->last_id && config->last_id <= RS_ID_LAST &&
         config->session != 0U;
}

static void boot(rs_section_unit* unit, const rs_section_unit_config* config, uint64_t now_ns) {
  memset(unit, 0, sizeof *unit);
  if (!valid(config)) return;
  unit->config = *config;
  if (config->cell_key != NULL) {
    uint8_t keys[RS_CELL_KEYS_BYTES];
    rs_cell_keys(config->cell_key, 0, keys);
    rs_chaskey_key_expand(&unit->key, keys);
    unit->turn = RS_TURN_NONE;
  }
  rs_ids_init(&unit->ids, config);
  unit->power = config->powered ? (uint16_t)((1U << config->ports) - 1U) : 0;
  unit->heartbeat_ns = unit->peers_due_ns = unit->booted_ns = now_ns;
  unit->leapt_ns = now_ns;
  unit->forming = true;
  for (unsigned port = 0; port < unit->config.ports; ++port) rs_rate_start(&unit->port[port].rate);
}

void rs_section_unit_step(rs_section_unit* unit, const rs_unit_input* input, uint64_t now_ns, rs_unit_output* output) {
  memset(output, 0, sizeof *output);
  output->timer_ns = UINT64_MAX;
  if (input->kind == RS_UNIT_INPUT_BOOT) boot(unit, input->config, now_ns);
  if (unit->config.ports == 0U) return; /* not booted */

  const unsigned port = (unsigned)input->port - 1U;
  rs_ports_tick(unit, now_ns);
  rs_unit_torque_tick(unit, now_ns);
  switch (input->kind) {
    case RS_UNIT_INPUT_FRAME:
      if (port < unit->config.ports) rs_ports_receive(unit, port, input->bytes, now_ns);
      break;
    case RS_UNIT_INPUT_SENT:
      if (port < unit->config.ports) unit->port[port].busy = false;
      break;
    case RS_UNIT_INPUT_DATAGRAM:
      rs_datagrams_receive(unit, input->bytes, input->count, now_ns);
      break;
    default:
      break;
  }
  rs_ports_transmit(unit, now_ns, output);
  const uint64_t torque_ns = rs_unit_torque_end(unit, now_ns);
  const uint64_t peers_ns = rs_peers_send(unit, now_ns, output);
  const uint64_t host_ns = output->datagram != NULL ? now_ns : rs_datagrams_send(unit, now_ns, output);
  const uint64_t tick_ns = (unit->tick_time + 1U) * RS_TICK_US * 1000U - unit->ahead_ns;
  const uint64_t datagram_ns = peers_ns < host_ns ? peers_ns : host_ns;
  output->timer_ns = datagram_ns < tick_ns ? datagram_ns : tick_ns;
  if (torque_ns < output->timer_ns) output->timer_ns = torque_ns;
  const uint64_t down_ns = rs_ports_due(unit);
  if (down_ns < output->timer_ns) output->timer_ns = down_ns;
  output->power = unit->power;
}
