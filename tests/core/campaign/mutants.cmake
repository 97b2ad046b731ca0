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
