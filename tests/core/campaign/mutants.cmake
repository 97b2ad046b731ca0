# The rules that are broken on purpose, one a mutant. Semicolons in a text would split it: leave them out.
campaign_mutant(newer_or_equal include/robotskin/feasibility.h
  "return offer.sequence == bound.sequence && offer.hops < bound.hops"
  "return offer.sequence == bound.sequence")
campaign_mutant(no_feasible_distance include/robotskin/feasibility.h
  "return offer.sequence == bound.sequence && offer.hops < bound.hops"
  "return true")
campaign_mutant(own_child_allowed
  network/route.c
  "if (port + 1U == route->parent_port || neighbour->child || !rs_link_usable(neighbour)) continue"
  "if (port + 1U == route->parent_port || !rs_link_usable(neighbour)) continue"
  network/route.c
  "if (neighbour->child || rs_move_advance(cell, port, now_us)"
  "if (rs_move_advance(cell, port, now_us)")
campaign_mutant(no_quarantine network/route.c
  "route->in_quarantine = true"
  "route->in_quarantine = false")
campaign_mutant(tags_unchecked network/chaskey.c
  "return ((difference | (0U - difference)) >> 31) == 0U"
  "return difference == difference")
campaign_mutant(torques_counted_twice network/torque_epoch.c
  "if (!rs_hearing_first(&neighbour->hearing, torque.serial)) return"
  "(void)rs_hearing_first(&neighbour->hearing, torque.serial)")
campaign_mutant(torques_not_awaited network/torque_epoch.c
  "epoch->waiting |= (uint8_t)(1U << port)"
  "(void)port")
campaign_mutant(torques_miscounted network/torque_epoch.c
  "sum.cells = 1"
  "sum.cells = 2")
campaign_mutant(events_unmarked network/retention.c
  "if (ring->sent < ring->tried) rs_frame_mark_replayed"
  "if (false) rs_frame_mark_replayed")
campaign_mutant(events_forgotten include/robotskin/timing.h
  "RS_RETENTION_US = 12000"
  "RS_RETENTION_US = 100")
campaign_mutant(neighbours_mixed_up network/identity.c
  ".neighbour_2 = id[1]"
  ".neighbour_2 = id[0]")
campaign_mutant(never_thinned_out section_unit/rate.c
  "if (least > DIVISOR_MAX) least = DIVISOR_MAX"
  "if (least > 1U) least = 1U")
