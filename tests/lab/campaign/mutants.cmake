# SPDX-License-Identifier: Apache-2.0
# The rules that are broken on purpose, one a mutant. Semicolons in a text would split it: leave them out.

# ---- Parents: R1 to R9 ----
campaign_mutant(newer_or_equal include/robotskin/feasibility.h
  "return offer.sequence == bound.sequence && offer.hops < bound.hops"
  "return offer.sequence == bound.sequence")
campaign_mutant(no_feasible_distance include/robotskin/feasibility.h
  "return offer.sequence == bound.sequence && offer.hops < bound.hops"
  "return true")
campaign_mutant(distance_not_kept cell/routing/parent.c
  "} else if (route->hops < route->feasible_hops) {"
  "} else if (false) {")
campaign_mutant(hops_uncounted cell/routing/parent.c
  "route->hops = (uint8_t)(neighbour->hops + 1U)"
  "route->hops = neighbour->hops")
campaign_mutant(ticks_made_by_cells cell/routing/parent.c
  "route->wave = neighbour->wave"
  "route->wave = neighbour->wave, ++route->wave.sequence")
campaign_mutant(own_child_allowed
  cell/routing/parent.c
  "if (port + 1U == route->parent_port || neighbour->child || !rs_link_usable(neighbour)) continue"
  "if (port + 1U == route->parent_port || !rs_link_usable(neighbour)) continue"
  cell/routing/route.c
  "if (neighbour->child || rs_move_advance(cell, port, now_us)"
  "if (rs_move_advance(cell, port, now_us)")
campaign_mutant(no_quarantine cell/routing/parent.c
  "route->in_quarantine = true"
  "route->in_quarantine = false")
campaign_mutant(deaf_neighbours_used cell/routing/beacons.c
  "neighbour->hears_us = tick.heard != 0U"
  "neighbour->hears_us = true")
campaign_mutant(silence_unnoticed include/robotskin/timing.h
  "RS_LINK_DOWN_US = 3500"
  "RS_LINK_DOWN_US = 35000")
campaign_mutant(way_lost_untold cell/routing/parent.c
  "++cell->counts.orphanings"
  "return")
campaign_mutant(never_nearer cell/routing/route.c
  "const int wanted = same || too_deep ? 1 : (int)route->wave.gain_threshold"
  "const int wanted = 64")
campaign_mutant(zombies_followed cell/routing/route.c
  "if (now_us - route->advanced_us > RS_STALE_US && ahead >= RS_STALE_TICKS && ahead < 0x8000U) {"
  "if (false) {")
campaign_mutant(far_ahead_believed cell/routing/beacons.c
  "ahead > RS_SEQUENCE_WINDOW && ahead < 0x8000U) {"
  "false) {")
campaign_mutant(wrap_unknown include/robotskin/feasibility.h
  "return ahead != 0U && ahead < 0x8000U"
  "return ahead != 0U && a > b")
campaign_mutant(damaged_time_believed cell/memory/known_time.h
  "return route->known_time == ~route->known_time_complement"
  "return true")

# ---- Moves and levelling: R10 ----
campaign_mutant(moves_not_held cell/routing/moves.c
  "begin_handover(cell, best, route->told_size, now_us)"
  "rs_route_adopt(cell, best, now_us)")
campaign_mutant(moves_lose_samples cell/routing/parent.c
  "if (moved) route->handover = false"
  "if (moved) route->handover = false, rs_queues_forget_samples(cell)")
campaign_mutant(moves_too_deep cell/routing/moves.c
  "return target->hops + 1U + route->subtree_height <= wave->depth_cap"
  "return true"
  cell/routing/offers.c
  "if (hops + route->subtree_height > route->wave.depth_cap) continue;"
  "")
campaign_mutant(sizes_uncounted cell/routing/subtree.c
  "size += neighbour->size"
  "size += 1U")
campaign_mutant(levelled_uphill section_unit/demands.c
  "if (!rs_trees_beside(trees, k, j) || trees->size[k] <= trees->size[j] + 1U) continue"
  "if (!rs_trees_beside(trees, k, j) || trees->size[j] <= trees->size[k] + 1U) continue"
  section_unit/demands.c
  "const uint32_t more = (uint32_t)trees->size[k] - trees->size[j]"
  "const uint32_t more = (uint32_t)trees->size[j] - trees->size[k]"
  section_unit/demands.c
  "return trees->size[k] > taken ? trees->size[k] - taken : 0U"
  "return taken > trees->size[k] ? taken - trees->size[k] : 0U"
  section_unit/balance.c
  "if (taken + offer->size > unit->port[port].size) return false"
  "(void)taken")
campaign_mutant(never_levelled section_unit/balance.c
  "if (tick >= balance->decide_at && fits(unit, port)) {"
  "if (fits(unit, port) && balance->failed > 1000U) {")
campaign_mutant(stuck_child_counts_again cell/link/link.c
  "if (neighbour->stale) return neighbour->child && behind != 0U"
  "if (neighbour->stale) return neighbour->child && (uint16_t)behind != 0U && (uint16_t)behind < 0x8000U")

campaign_mutant(serials_kept_for_ever cell/torque/torque_epoch.c
  "rs_arq_receiver_epoch(&neighbour->arq_receiver);"
  "")
campaign_mutant(serials_forgotten_too_soon cell/torque/torque_epoch.c
  "    --epoch->reports[port];"
  "    if (--epoch->reports[port] == 0U) neighbour->arq_receiver.serials = 0;"
  section_unit/torque.c
  "if (unit->torque.reports[port] > 0U) --unit->torque.reports[port];"
  "if (unit->torque.reports[port] > 0U && --unit->torque.reports[port] == 0U) unit->port[port].arq_receiver.serials = 0;")

# ---- Tags, and what is played again ----
campaign_mutant(tags_unchecked cell/wire/chaskey.c
  "return ((difference | (0U - difference)) >> 31) == 0U"
  "return difference == difference")
campaign_mutant(another_cipher cell/wire/chaskey.c
  "v[1] = rotated_left(v[1], 7) ^ v[2]"
  "v[1] = rotated_left(v[1], 6) ^ v[2]")
campaign_mutant(ticks_unchecked cell/routing/beacons.c
  "return rs_tags_equal(rs_wave_tag(&cell->key, wave), wave->tag)"
  "return true")
campaign_mutant(grants_unchecked cell/routing/moves.c
  "if (cell->keyed && !rs_tags_equal(rs_command_tag(cell->turn_key, frame, time), grant.tag)) {"
  "if (false) {")
campaign_mutant(commands_unchecked cell/commands.c
  "if (!cell->keyed) return true"
  "if (true) return true")
campaign_mutant(joints_unchecked cell/torque/joints.c
  "(cell->keyed && !rs_tags_equal(rs_joints_tag(cell->turn_key, frame, epoch), joints.tag))"
  "(false)")
campaign_mutant(ticks_played_again cell/routing/beacons.c
  "if (from_before(neighbour, &tick, &wave, now_us) || "
  "if (")
campaign_mutant(commands_played_again cell/commands.c
  "if (!rs_newer((uint16_t)command->counter, commanding->counter)) {"
  "if (false) {")
campaign_mutant(joints_played_again cell/torque/joints.c
  "if (state->known[joints.limb] >> joints.part & 1U && (uint8_t)(*newest - epoch) < EPOCHS_OLD) {"
  "if (false) {")

# ---- Samples, events and queues ----
campaign_mutant(samples_unmarked cell/transmit.c
  "rs_frame_mark_retransmitted(frame)"
  "(void)again")
campaign_mutant(samples_of_others cell/sampling.c
  ".source = cell->id"
  ".source = cell->id + 1U")
campaign_mutant(samples_gathered cell/transmit.c
  "if (queues->data.count > 0U) {"
  "if (queues->data.count > 8U) {"
  cell/fast_path.h
  "return ready == queues->parent_bit && queues->samples_next && queues->data.count != 0U"
  "return ready == queues->parent_bit && queues->samples_next && queues->data.count > 8U")
campaign_mutant(samples_newest_first cell/transport/rings.h
  "rs_ring_take(&queues->data, queues->data_frame, RS_QUEUE_DATA, frame)"
  "rs_frame_copy(frame, queues->data_frame[(queues->data.first + --queues->data.count) & (RS_QUEUE_DATA - 1U)])")
campaign_mutant(queues_unbounded cell/transport/queues.c
  "if (queues->data.count >= RS_QUEUE_DATA) {"
  "if (queues->data.count >= 2U * RS_QUEUE_DATA) {"
  cell/transport/queues.c
  "place = rs_ring_append(&queues->data, queues->data_frame, RS_QUEUE_DATA)"
  "place = rs_ring_place(&queues->data, queues->data_frame, RS_QUEUE_DATA)")
campaign_mutant(sampling_unhealed cell/time/sample_clock.c
  "if ((sampling->running != 0U) != wanted || (wanted && far)) rs_sampling_restart(cell, now_us)"
  "(void)wanted, (void)far")
campaign_mutant(thinned_out_too_much cell/time/sample_clock.c
  "return (number + id) % divisor != 0U"
  "return (number + id) % (2U * divisor) != 0U")
campaign_mutant(divisor_ignored cell/time/sample_clock.c
  "return (number + id) % divisor != 0U"
  "return number == 0U && divisor == 0U")
campaign_mutant(never_thinned_out section_unit/rate.c
  "if (least > DIVISOR_MAX) least = DIVISOR_MAX"
  "if (least > 1U) least = 1U")
campaign_mutant(never_fresh cell/sampling.c
  "const bool refresh = due || now_us - sampling->sent_us + period_us >= silence_us(cell)"
  "const bool refresh = due && silence_us(cell) > 0U")
campaign_mutant(changes_unsent cell/sampling.c
  "if (event || refresh) send("
  "if (refresh) send(")
campaign_mutant(events_unmarked cell/transport/arq_sender.c
  "if (ring->sent < ring->tried) rs_frame_mark_retransmitted"
  "if (false) rs_frame_mark_retransmitted")
campaign_mutant(events_forgotten include/robotskin/timing.h
  "RS_ARQ_KEEP_US = 12000"
  "RS_ARQ_KEEP_US = 100")
campaign_mutant(ack_ignored cell/transport/arq_sender.c
  "if ((ack & RS_ARQ_MISSED) == 0U) return"
  "return")
campaign_mutant(beacons_unlimited cell/transmit.c
  "if (now_us - *last_us < RS_BEACONS_US) continue"
  "(void)0")
campaign_mutant(status_unlimited cell/time/timer.c
  "return pause_us > fill_us ? pause_us : fill_us"
  "return pause_us > fill_us ? pause_us : 0U")

# ---- Torque sums ----
campaign_mutant(torques_counted_twice cell/torque/torque_epoch.c
  "if (!rs_arq_receiver_first(&neighbour->arq_receiver, torque.serial)) return"
  "(void)rs_arq_receiver_first(&neighbour->arq_receiver, torque.serial)")
campaign_mutant(epochs_begun_twice cell/torque/torque_epoch.c
  "if (behind >= BACK) begin("
  "if (true) begin(")
campaign_mutant(torques_not_awaited cell/torque/torque_epoch.c
  "epoch->waiting |= (uint8_t)(1U << port)"
  "(void)port")
campaign_mutant(torques_miscounted cell/torque/torque_epoch.c
  "sum.cells = 1"
  "sum.cells = 2")

campaign_mutant(levers_shortened cell/torque/chain.c
  "point[i] += place->offset[i]"
  "point[i] += 0 * place->offset[i]")

campaign_mutant(stuck_wants_counted section_unit/demands.c
  "|| !other->open || rs_demands_stuck(other)) continue;"
  "|| !other->open) continue;")

# ---- What the host is told ----
campaign_mutant(neighbours_mixed_up cell/routing/identity.c
  ".neighbour_2 = id[1]"
  ".neighbour_2 = id[0]")
campaign_mutant(orders_held_up cell/transport/queues.c
  "all = (1U << RS_PORTS) - 1U"
  "all = ~0U")
campaign_mutant(orders_out_of_order cell/commands.c
  "if (!rs_newer((uint16_t)command->counter, commanding->counter)) {"
  "if (rs_newer((uint16_t)command->counter, commanding->counter)) {")
