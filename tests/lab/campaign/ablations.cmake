# SPDX-License-Identifier: Apache-2.0
# The shipping firmware without one mechanism of load balancing: robotskin_lab/bench/network_mechanisms.py tells of each.
campaign_mutant(without_balance section_unit/balance.c
  "if (unit->tick_time % RS_BALANCE_TICKS == 0U) start_round(unit, now_ns)"
  "if (false) start_round(unit, now_ns)")
campaign_mutant(without_depth_raise section_unit/depth_cap.c
  "if (failing == wanting || lead->stalled >= RS_STALLED_ROUNDS) {"
  "if (false) {")
campaign_mutant(without_depth_of_others section_unit/depth_cap.c
  "if (there > deepest) deepest = there"
  "if (false) deepest = there")
campaign_mutant(without_potentials section_unit/demands.c
  "int64_t flow = unit->potential[trees->root[k]] - unit->potential[trees->root[j]]"
  "int64_t flow = ((int64_t)trees->size[k] - (int64_t)trees->size[j]) * RS_POTENTIAL_SCALE / 2")
campaign_mutant(without_wider_wants section_unit/demands.c
  "if (balance->failed > 0U && levelling > size) size"
  "if (false) size")
campaign_mutant(without_last_resort section_unit/demands.c
  "balance->last_resort = balance->failed > 0U"
  "balance->last_resort = false")
campaign_mutant(without_smallest_first cell/routing/offers.c
  "const int32_t first = route->demands.last_resort ? -larger : cheaper"
  "const int32_t first = cheaper"
  cell/routing/offers.c
  "const int32_t second = route->demands.last_resort ? cheaper : larger"
  "const int32_t second = larger")
campaign_mutant(without_letting_go cell/routing/subtree.c
  "if (!may_yield || !hangs_at_border(cell)) {"
  "if (true) {")
campaign_mutant(without_turns cell/routing/subtree.c
  "return (demands->round & 6U) != 0U"
  "return false")
campaign_mutant(without_detour cell/routing/moves.c
  "if (route->draining_ticks <= DETOUR_TICKS + route->subtree_height) return"
  "if (true) return")
campaign_mutant(without_round_about section_unit/demands.c
  "const bool desperate = balance->failed >= RS_FAILED_ROUNDS && lead->stalled < 4U * RS_STALLED_ROUNDS"
  "const bool desperate = false")
campaign_mutant(without_lean_moves cell/routing/offers.c
  "lean = route->demands.last_resort && captive_size <= wanted"
  "lean = false")
