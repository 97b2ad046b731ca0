# SPDX-License-Identifier: Apache-2.0
"""Draws docs/pictures/architecture.svg from the table of the flow in ARCHITECTURE.md.

A test compares the drawing with the page, so that both say the same. Colours follow the reader's light
or dark theme.
"""

import html
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FILE = Path(__file__).with_name("pictures") / "architecture.svg"
WIDTH, BOX, STEP, TOP = 760, 46, 64, 46

STYLE = """
    text { font: 14px system-ui, sans-serif; fill: #1f2328; }
    .small { font-size: 12px; fill: #59636e; }
    .box { fill: #f6f8fa; stroke: #59636e; }
    .end { fill: #fff8c5; stroke: #9a6700; stroke-dasharray: 5 3; }
    .line { stroke: #0969da; stroke-width: 2; fill: none; }
    .head { fill: #0969da; }
    @media (prefers-color-scheme: dark) {
      text { fill: #f0f6fc; } .small { fill: #9198a1; }
      .box { fill: #151b23; stroke: #9198a1; } .end { fill: #272115; stroke: #d29922; }
      .line { stroke: #4493f8; } .head { fill: #4493f8; }
    }"""


def stages() -> list[tuple[str, str, str]]:
    """Name, first folder, and what goes in and out, of each stage that a touch passes."""
    page = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d) \| ([a-z ]+) \| `([^`]+)`[^|]*\| ([^|]+?) \|", page, re.MULTILINE)
    aside = {"robot model", "selfconfig"}
    return [(name, folder, passes) for _, name, folder, passes in rows if name not in aside]


def drawing() -> str:
    """The drawing as SVG."""
    parts = []
    boxes = [
        ("contact", "`core/world/`", "the simulated or the real skin is touched", "end"),
        *((name, f"`{folder}`", passes, "box") for name, folder, passes in stages()),
        ("motor", "`core/world/`", "RobotPort: the simulated or the real robot moves", "end"),
    ]
    for index, (name, folder, passes, kind) in enumerate(boxes):
        y = TOP + index * STEP
        parts.append(f'<rect class="{kind}" x="170" y="{y}" width="420" height="{BOX}" rx="6"/>')
        parts.append(f'<text x="184" y="{y + 19}">{html.escape(name)}</text>')
        parts.append(f'<text class="small" x="576" y="{y + 19}" text-anchor="end">{folder.strip("`")}</text>')
        parts.append(f'<text class="small" x="184" y="{y + 37}">{html.escape(short(passes))}</text>')
        if index:
            parts.append(f'<path class="line" d="M380 {y - STEP + BOX} V{y - 8}"/>')
            parts.append(f'<path class="head" d="M380 {y} l-5 -9 h10 z"/>')
    names = [name for name, *_ in boxes]
    last = TOP + (len(boxes) - 1) * STEP
    middle = TOP + names.index("skin") * STEP + BOX / 2
    control = TOP + names.index("control") * STEP + BOX / 2
    parts += [
        f'<path class="line" d="M590 {last + BOX / 2} H690 V{TOP + BOX / 2} H600"/>',
        f'<path class="head" d="M590 {TOP + BOX / 2} l9 -5 v10 z"/>',
        f'<text class="small" x="700" y="{(TOP + last) / 2}" transform="rotate(90 700 {(TOP + last) / 2})"'
        ' text-anchor="middle">the body moves, and the touch with it</text>',
        f'<path class="line" d="M170 {middle} H120"/>',
        f'<rect class="box" x="14" y="{middle - 22}" width="106" height="44" rx="6"/>',
        f'<text class="small" x="67" y="{middle - 4}" text-anchor="middle">selfconfig</text>',
        f'<text class="small" x="67" y="{middle + 12}" text-anchor="middle">SkinModel</text>',
        f'<path class="line" d="M170 {control} H120"/>',
        f'<rect class="box" x="14" y="{control - 22}" width="106" height="44" rx="6"/>',
        f'<text class="small" x="67" y="{control - 4}" text-anchor="middle">robot model</text>',
        f'<text class="small" x="67" y="{control + 12}" text-anchor="middle">from URDF</text>',
        '<text class="small" x="380" y="26" text-anchor="middle">A stage knows only the types of the stages above it'
        "</text>",
    ]
    body = "\n  ".join(parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {last + BOX + 16}" role="img"'
        f' aria-label="The flow of touch through the stages">\n  <style>{STYLE}\n  </style>\n  {body}\n</svg>\n'
    )


def short(text: str, most: int = 62) -> str:
    """A line that fits its box: without code marks, cut at a word."""
    plain = text.replace("`", "")
    if len(plain) <= most:
        return plain
    cut = plain[:most].rsplit(" ", 1)[0].rstrip(",;:")
    return f"{cut} …"


if __name__ == "__main__":
    FILE.write_text(drawing(), encoding="utf-8")
