# SPDX-License-Identifier: Apache-2.0
"""Small changes of sources: what is changed, what is left alone, and that a draw repeats."""

from robotskin_lab.campaign.mutants import source_tree
from robotskin_lab.campaign.mutation import drawn, mutations, sources

SOURCE = """\
/* a < b */
#define LIMIT (3 + 4)
RS_STATIC_ASSERT(LIMIT > 2, "more than 2");
static int least(const int* a, int count) {
  int best = a[0];
  for (int i = 1; i < count; ++i) {
    if (!(a[i] >= best) && count != 0) best = a[i]; // not -1
  }
  note(best);
  return -best;
}
"""


def changes() -> set[tuple[str, str]]:
    return {(one.before, one.after) for one in mutations("x.c", SOURCE)}


def test_operators_constants_conditions_and_statements_are_changed() -> None:
    wanted = {("<", "<="), (">=", ">"), ("!", ""), ("&&", "||"), ("!=", "=="), ("1", "2"), ("++", "--")}
    assert wanted | {("note(best)", "(void)0")} <= changes()


def test_comments_directives_assertions_signs_and_pointers_stay() -> None:
    for one in mutations("x.c", SOURCE):
        line = SOURCE.splitlines()[one.line - 1]
        assert not line.startswith(("/*", "#", "RS_STATIC_ASSERT")), one
        assert one.before not in ("-", "*"), one


def test_a_change_changes_just_that_and_each_source_has_some(seed: int) -> None:
    firmware = source_tree() / "firmware"
    texts = sources(firmware)
    for one in drawn(firmware, 200, seed):
        text = texts[one.path]
        changed = one.applied(text)
        assert changed != text
        assert changed[: one.at] == text[: one.at]
        assert changed.endswith(text[one.at + len(one.before) :])
    assert drawn(firmware, 20, seed) == drawn(firmware, 20, seed) != drawn(firmware, 20, seed + 1)
    assert all(any(mutations(path, text)) for path, text in texts.items() if path.endswith(".c"))
