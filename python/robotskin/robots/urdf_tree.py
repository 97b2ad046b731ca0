# SPDX-License-Identifier: Apache-2.0
"""The text of a URDF as a tree of elements: read, checked to describe one robot, and put in order."""

import math
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from robotskin.robots.errors import MalformedUrdfError


def parse_urdf(text: str, source: str) -> ElementTree.Element:
    """The `<robot>` element; `source` names the text in errors. Raises MalformedUrdfError."""
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise MalformedUrdfError(source, f"not well-formed XML: {error}") from error
    if root.tag != "robot":
        raise MalformedUrdfError(source, f"the outermost element is <{root.tag}>, and a URDF begins with <robot>")
    if not root.get("name"):
        root.set("name", Path(source).stem)
    return root


def named_elements(root: ElementTree.Element, tag: str, source: str) -> dict[str, ElementTree.Element]:
    """The elements of one tag by their names; raises MalformedUrdfError for names that are missing or double."""
    elements: dict[str, ElementTree.Element] = {}
    for element in root.findall(tag):
        name = element.get("name")
        if not name:
            raise MalformedUrdfError(source, f"a <{tag}> without a name")
        if name in elements:
            raise MalformedUrdfError(source, f"two of <{tag} name={name!r}>; names must differ")
        elements[name] = element
    if tag == "link" and not elements:
        raise MalformedUrdfError(source, "no <link>")
    return elements


def link_of(joint: ElementTree.Element, end: str) -> str:
    """The link at the `parent` or `child` end of a joint, empty if it has none."""
    element = joint.find(end)
    return "" if element is None else element.get("link", "")


def numbers(text: str | None, count: int, where: str, source: str) -> np.ndarray:
    """(count) finite numbers of an attribute; raises MalformedUrdfError, which says `where` it stands."""
    try:
        values = np.array([float(word) for word in (text or "").split()])
    except ValueError:
        values = np.empty(0)
    if len(values) != count or not np.isfinite(values).all():
        expected = "a finite number" if count == 1 else f"{count} finite numbers"
        raise MalformedUrdfError(source, f"{where}: {text!r} is not {expected}")
    return values


def check_origin(element: ElementTree.Element, where: str, source: str) -> None:
    """Raises MalformedUrdfError unless an element's `<origin>`, if it has one, holds finite numbers."""
    origin = element.find("origin")
    for part in ("xyz", "rpy"):
        if origin is not None and origin.get(part) is not None:
            numbers(origin.get(part), 3, f"{where}, <origin {part}>", source)


def check_tree(links: dict[str, ElementTree.Element], joints: dict[str, ElementTree.Element], source: str) -> None:
    """Raises MalformedUrdfError unless the joints make one tree of all links."""
    above: dict[str, str] = {}
    for name, joint in joints.items():
        for end in ("parent", "child"):
            if link_of(joint, end) not in links:
                raise MalformedUrdfError(source, f"joint {name!r}: its {end} {link_of(joint, end)!r} is not a link")
        child = link_of(joint, "child")
        if child in above:
            raise MalformedUrdfError(
                source, f"link {child!r} is the child of two joints, {above[child]!r} and {name!r}"
            )
        above[child] = name
    bases = [link for link in links if link not in above]
    if len(bases) != 1:
        raise MalformedUrdfError(source, f"a robot has one base link, here are {len(bases)}: {', '.join(bases)}")
    reached, waiting = set(), bases
    while waiting:
        reached.add(waiting.pop())
        waiting = [link_of(j, "child") for j in joints.values() if link_of(j, "parent") in reached]
        waiting = [link for link in waiting if link not in reached]
    if len(reached) != len(links):
        raise MalformedUrdfError(source, f"links in a loop: {', '.join(sorted(set(links) - reached))}")


def in_joint_order(root: ElementTree.Element, joint_names: Sequence[str]) -> str:
    """The text with joints and links in depth-first order, children by the place of their first joint in the list.

    Libraries number joints by name or by place in the text; after this both come to the same.
    """
    rank = {name: index for index, name in enumerate(joint_names)}
    below: dict[str, list[ElementTree.Element]] = {}
    for joint in root.findall("joint"):
        below.setdefault(link_of(joint, "parent"), []).append(joint)
    links = {link.get("name", ""): link for link in root.findall("link")}
    base = next(iter(set(links) - {link_of(joint, "child") for joint in root.findall("joint")}))

    def first_rank(joint: ElementTree.Element) -> float:
        own = rank.get(joint.get("name", ""), math.inf)
        return min([own, *(first_rank(child) for child in below.get(link_of(joint, "child"), ()))])

    ordered: list[ElementTree.Element] = []

    def visit(link: str) -> None:
        ordered.append(links[link])
        for joint in sorted(below.get(link, ()), key=lambda joint: (first_rank(joint), joint.get("name", ""))):
            ordered.append(joint)
            visit(link_of(joint, "child"))

    visit(base)
    others = [child for child in root if child.tag not in ("link", "joint")]
    result = ElementTree.Element(root.tag, root.attrib)
    result.extend([*others, *ordered])
    ElementTree.indent(result)
    return ElementTree.tostring(result, encoding="unicode")
