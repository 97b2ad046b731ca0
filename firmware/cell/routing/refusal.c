/* SPDX-License-Identifier: Apache-2.0
 * A budget of wrong tags that is spent closes its port. Links and reports ask for the budgets themselves, hence this
 * is apart from the counting. */
#include "cell/routing/refusal.h"

#include "cell/routing/identity.h"
#include "cell/routing/links.h"
#include "cell/routing/wrong_tags.h"

void rs_refuse_tag(rs_cell* cell, unsigned place, uint32_t now_us) {
  if (!rs_tags_spend(cell, place)) return;
  if (place == RS_UNREAD) {
    rs_identity_changed(cell, now_us);
  } else {
    rs_link_down(cell, place, now_us);
  }
}
