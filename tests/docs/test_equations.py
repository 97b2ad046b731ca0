# SPDX-License-Identifier: Apache-2.0
"""Every equation of the paper is marked at the line that computes it, and the page of equations says where."""

import re
from pathlib import Path

import equation_table
import pytest
from symbols import ROOT, line_of, symbol_at

LITERAL = {4, 5, 15}
"""The laboratory alone has these, for comparison; the product comes to the same by others."""


def test_every_equation_is_computed_somewhere(capsys: pytest.CaptureFixture[str]) -> None:
    found = equation_table.places()
    with capsys.disabled():
        print()
        for place in found:
            what = equation_table.WHAT[place.equation]
            print(f"  eq. {place.equation:2d}  {what:60s} {place.path}:{place.line}")
    assert {place.equation for place in found} >= set(equation_table.WHAT)
    assert {place.equation for place in found if place.of_product} >= set(equation_table.WHAT) - LITERAL


def test_every_marked_line_is_code_of_a_function() -> None:
    for place in equation_table.places():
        line = (ROOT / place.path).read_text(encoding="utf-8").splitlines()[place.line - 1]
        assert place.symbol, place
        assert re.match(r"\s*[^\s#/*]", line), place


def test_the_page_shows_the_table() -> None:
    page = equation_table.PAGE.read_text(encoding="utf-8")
    assert page == equation_table.with_table(page), "run make docs"


def test_sources_cite_the_paper_in_one_way() -> None:
    """`[Cheng19 eq. N]`, so that one search finds all; equations of other papers stand on a line that names them."""
    loose = []
    for pattern in (*equation_table.SOURCES, "firmware/**/*.h", "core/**/*.hpp", "lab/core/**/*.hpp"):
        for path in ROOT.glob(pattern):
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                cites_other = re.search(r"IEEE|[0-9]{4}, eq\.", line)
                bare = re.search(r"(?<!Cheng19 )\b[Ee]q\. ?\d", line)
                continued = line.lstrip("/ *").startswith("eq.")
                if bare and not cites_other and not continued:
                    loose.append(f"{path.relative_to(ROOT)}:{number}: {line.strip()}")
    assert not loose, "\n".join(loose)


C_SOURCE = """static int inner(int a,
                 int b) {
  if (a > b) {
    return a;
  }
  return b;
}

Thing::Thing(int a)
    : a_(a),
      b_(2) {
  use(a);
}

struct Other {
  bool fuse(int a) noexcept {
    return a > 0;
  }
};
"""


def test_a_line_is_found_in_its_function(tmp_path: Path) -> None:
    source = tmp_path / "source.cpp"
    source.write_text(C_SOURCE)
    assert [symbol_at(source, line) for line in (4, 6, 12, 17)] == ["inner", "inner", "Thing::Thing", "fuse"]
    assert symbol_at(source, 19) == ""
    assert [line_of(source, name) for name in ("inner", "Thing", "fuse")] == [1, 9, 16]


def test_a_line_of_python_is_found_in_its_function(tmp_path: Path) -> None:
    source = tmp_path / "source.py"
    source.write_text("class A:\n    def b(self):\n        return 1\n\n\nx = 1\n")
    assert symbol_at(source, 3) == "A.b"
    assert symbol_at(source, 6) == ""
    assert line_of(source, "b") == 2


def test_an_unknown_function_is_named(tmp_path: Path) -> None:
    with pytest.raises(LookupError, match="no function or class nowhere"):
        line_of(ROOT / "docs/symbols.py", "nowhere")
