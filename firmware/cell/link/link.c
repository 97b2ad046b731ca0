/* SPDX-License-Identifier: Apache-2.0
 * What one neighbour is: whether its line carries frames both ways, damages them, or the cell behind it is stuck. */
#include "cell/link/link.h"

#include "cell/wire/wave.h"

bool rs_link_usable(const rs_neighbour* neighbour) {
  return neighbour->up && neighbour->hears_us;
}

/* Time that is left from now until the bucket of damaged frames is empty. More than it holds is damaged memory. */
static uint32_t damage_left_us(const rs_neighbour* neighbour, uint32_t now_us) {
  const uint32_t left_us = neighbour->damage_until_us - now_us;
  return left_us <= RS_LOSSY_MAX_US ? left_us : 0U;
}

bool rs_link_lossy(const rs_neighbour* neighbour, uint32_t now_us) {
  return damage_left_us(neighbour, now_us) > RS_LOSSY_MANY_US;
}

void rs_link_damage(rs_neighbour* neighbour, uint32_t now_us) {
  const uint32_t left_us = damage_left_us(neighbour, now_us) + RS_LOSSY_US;
  ++neighbour->lost;
  neighbour->damage_until_us = now_us + (left_us < RS_LOSSY_MAX_US ? left_us : RS_LOSSY_MAX_US);
  /* A line that damages frames is no dead one: only silence is, or a neighbour from which nothing new comes through. */
  if (neighbour->up && !neighbour->stale && now_us - neighbour->heard_us < RS_LINK_DOWN_US)
    neighbour->heard_us = now_us;
}

bool rs_link_lagging(const rs_route* route, const rs_neighbour* neighbour, uint32_t now_us) {
  /* It may have gone unheard, and is counted where it is then. */
  if (rs_link_lossy(neighbour, now_us)) return neighbour->child;
  const uint32_t behind = rs_ticks_between(rs_wave_time(&neighbour->wave), rs_wave_time(&route->wave));
  /* However long a stuck child has said the same, what it says does not become new by that. */
  if (neighbour->stale) return neighbour->child && behind != 0U;
  /* What goes on taking over ticks only waits long to be heard: in a crowded cell ticks of children come through much
   * later than those of the parent, which stand behind no samples. */
  if (now_us - neighbour->turned_us <= RS_STALE_TICKS * RS_TICK_US) return false;
  return neighbour->child && behind > RS_STALE_TICKS && behind < RS_TICK_TIME_HALF;
}

bool rs_move_open(const rs_route* route, const rs_neighbour* neighbour) {
  const uint16_t behind = (uint16_t)(route->wave.sequence - neighbour->wave.sequence);
  return rs_link_usable(neighbour) && !neighbour->child && !neighbour->draining && neighbour->hops < RS_HOPS_MAX &&
         (behind < RS_STALE_TICKS || behind >= 0x8000U);
}
