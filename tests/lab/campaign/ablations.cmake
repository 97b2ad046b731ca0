# SPDX-License-Identifier: Apache-2.0
# The shipping firmware without one mechanism of load balancing: robotskin_lab/bench/network_mechanisms.py tells of each.
campaign_mutant(without_balance section_unit/balance.c
  "if (unit->tick_time % RS_BALANCE_TICKS == 0U) start_round(unit, now_ns)"
  "if (false) start_round(unit, now_ns)")
campaign_mutant(without_depth_raise section_unit/depth_cap.c
  "if (failing == wanting || lead->stalled >= STALLED_ROUNDS) {"
  "if (false) {")
campaign_mutant(without_last_resort section_unit/demands.c
  "balance->last_resort = balance->failed > 0U"
  "balance->last_resort = false")
campaign_mutant(without_turns cell/routing/subtree.c
  "return (demands->round & 6U) != 0U"
  "return false")
campaign_mutant(without_detour cell/routing/moves.c
  "if (route->draining_ticks <= DETOUR_TICKS + route->subtree_height) return"
  "if (true) return")
