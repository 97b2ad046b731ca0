"""Turns any URDF into one text from which every library builds the same robot, and lists what it changed."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from robotskin._core.model import UNBOUNDED
from robotskin.robots.errors import MalformedUrdfError
from robotskin.robots.inertia import consistent_inertia, read_inertia, write_inertia
from robotskin.robots.meshes import as_stl, find_mesh

# Given to what a joint moves if the description gives it no mass at all.
SMALLEST_MOVED_MASS_KG = 1e-3
SMALLEST_MOVED_INERTIA_KG_M2 = 1e-6

# What MuJoCo has to be told so that it takes the numbers of the text as they are.
_MUJOCO_COMPILER = {
    "strippath": "false",
    "discardvisual": "true",
    "fusestatic": "false",
    "balanceinertia": "false",
    "inertiafromgeom": "false",
}


@dataclass(frozen=True)
class Repair:
    """One change to a description: whose `what` (link or joint) it was, the value found, and what was done."""

    what: str
    value: str
    done: str

    def __str__(self) -> str:
        return f"{self.what}: {self.value}: {self.done}"


@dataclass(frozen=True)
class Mimic:
    """A joint the mechanism couples to another: position = multiplier · source position + offset (rad or m).

    The models treat it as a joint of its own, so that both have the same joints; who drives the robot applies it.
    """

    joint: str
    source: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class RepairedUrdf:
    """The text, and what is known about it that the text does not say."""

    root: ElementTree.Element
    repairs: tuple[Repair, ...]
    mimics: tuple[Mimic, ...]


def repaired(text: str, source: str, urdf_folder: Path, package_folders: Sequence[Path] = ()) -> RepairedUrdf:
    """Repairs the text of a URDF. `source` names it in errors; meshes are searched from `urdf_folder`.

    Raises MalformedUrdfError, MissingMeshError or UnreadableMeshError.
    """
    root = _parse(text, source)
    for child in list(root):
        if child.tag not in ("link", "joint", "material"):
            root.remove(child)
    repairs: list[Repair] = []
    links = _named(root, "link", source)
    joints = _named(root, "joint", source)
    _check_tree(links, joints, source)
    mimics = tuple(_free_mimic(joint) for joint in joints.values() if joint.find("mimic") is not None)
    for joint in joints.values():
        repairs += _repair_joint(joint, source)
    for link in links.values():
        repairs += _repair_inertial(link, source)
        _resolve_meshes(link, urdf_folder, package_folders, source)
    repairs += _give_mass_to_moved(links, joints)
    movable = {name for name, joint in joints.items() if joint.get("type") != "fixed"}
    mujoco = ElementTree.SubElement(root, "mujoco")
    ElementTree.SubElement(mujoco, "compiler", _MUJOCO_COMPILER)
    return RepairedUrdf(root, tuple(repairs), tuple(mimic for mimic in mimics if mimic.joint in movable))


def in_joint_order(root: ElementTree.Element, joint_names: Sequence[str]) -> str:
    """The text with joints and links in depth-first order, children by the place of their first joint in the list.

    Libraries number joints by name or by place in the text; after this both come to the same.
    """
    rank = {name: index for index, name in enumerate(joint_names)}
    below: dict[str, list[ElementTree.Element]] = {}
    for joint in root.findall("joint"):
        below.setdefault(_link_of(joint, "parent"), []).append(joint)
    links = {link.get("name", ""): link for link in root.findall("link")}
    base = next(iter(set(links) - {_link_of(joint, "child") for joint in root.findall("joint")}))

    def first_rank(joint: ElementTree.Element) -> float:
        own = rank.get(joint.get("name", ""), math.inf)
        return min([own, *(first_rank(child) for child in below.get(_link_of(joint, "child"), ()))])

    ordered: list[ElementTree.Element] = []

    def visit(link: str) -> None:
        ordered.append(links[link])
        for joint in sorted(below.get(link, ()), key=lambda joint: (first_rank(joint), joint.get("name", ""))):
            ordered.append(joint)
            visit(_link_of(joint, "child"))

    visit(base)
    others = [child for child in root if child.tag not in ("link", "joint")]
    result = ElementTree.Element(root.tag, root.attrib)
    result.extend([*others, *ordered])
    ElementTree.indent(result)
    return ElementTree.tostring(result, encoding="unicode")


def _parse(text: str, source: str) -> ElementTree.Element:
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise MalformedUrdfError(source, f"not well-formed XML: {error}") from error
    if root.tag != "robot":
        raise MalformedUrdfError(source, f"the outermost element is <{root.tag}>, and a URDF begins with <robot>")
    if not root.get("name"):
        root.set("name", Path(source).stem)
    return root


def _named(root: ElementTree.Element, tag: str, source: str) -> dict[str, ElementTree.Element]:
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


def _link_of(joint: ElementTree.Element, end: str) -> str:
    element = joint.find(end)
    return "" if element is None else element.get("link", "")


def _check_tree(links: dict[str, ElementTree.Element], joints: dict[str, ElementTree.Element], source: str) -> None:
    above: dict[str, str] = {}
    for name, joint in joints.items():
        for end in ("parent", "child"):
            if _link_of(joint, end) not in links:
                raise MalformedUrdfError(source, f"joint {name!r}: its {end} {_link_of(joint, end)!r} is not a link")
        child = _link_of(joint, "child")
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
        waiting = [_link_of(j, "child") for j in joints.values() if _link_of(j, "parent") in reached]
        waiting = [link for link in waiting if link not in reached]
    if len(reached) != len(links):
        raise MalformedUrdfError(source, f"links in a loop: {', '.join(sorted(set(links) - reached))}")


def _numbers(text: str | None, count: int, where: str, source: str) -> np.ndarray:
    try:
        values = np.array([float(word) for word in (text or "").split()])
    except ValueError:
        values = np.empty(0)
    if len(values) != count or not np.isfinite(values).all():
        expected = "a finite number" if count == 1 else f"{count} finite numbers"
        raise MalformedUrdfError(source, f"{where}: {text!r} is not {expected}")
    return values


def _free_mimic(joint: ElementTree.Element) -> Mimic:
    mimic = joint.find("mimic")
    assert mimic is not None
    joint.remove(mimic)
    multiplier, offset = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
    return Mimic(joint.get("name", ""), mimic.get("joint", ""), multiplier, offset)


def _repair_joint(joint: ElementTree.Element, source: str) -> Iterable[Repair]:
    name, kind = joint.get("name", ""), joint.get("type")
    where = f"joint {name!r}"
    if kind not in ("revolute", "continuous", "prismatic", "fixed"):
        raise MalformedUrdfError(
            source, f"{where} is of type {kind!r}; a joint is revolute, continuous, prismatic or fixed"
        )
    origin = joint.find("origin")
    for part in ("xyz", "rpy"):
        if origin is not None and origin.get(part) is not None:
            _numbers(origin.get(part), 3, f"{where}, <origin {part}>", source)
    if kind == "fixed":
        for useless in ("axis", "limit", "dynamics", "safety_controller", "calibration"):
            for element in joint.findall(useless):
                joint.remove(element)
        return
    axis = joint.find("axis")
    if axis is not None:
        direction = _numbers(axis.get("xyz"), 3, f"{where}, <axis xyz>", source)
        length = float(np.linalg.norm(direction))
        if length < 1e-9:
            raise MalformedUrdfError(source, f"{where}: its axis is {axis.get('xyz')!r}, which has no direction")
        if abs(length - 1.0) > 1e-12:
            axis.set("xyz", " ".join(repr(float(part)) for part in direction / length))
        if abs(length - 1.0) > 1e-3:
            yield Repair(where, f"axis of length {length:.6g}", "made a unit vector")
    limit = joint.find("limit")
    if kind == "continuous":
        joint.set("type", "revolute")
        limit = ElementTree.SubElement(joint, "limit") if limit is None else limit
        limit.set("lower", repr(-UNBOUNDED))
        limit.set("upper", repr(UNBOUNDED))
        for bound in ("effort", "velocity"):
            limit.set(bound, limit.get(bound, repr(UNBOUNDED)))
    if limit is None:
        raise MalformedUrdfError(source, f"{where} is {kind} and has no <limit>")
    for bound in ("lower", "upper", "effort", "velocity"):
        limit.set(bound, limit.get(bound, "0"))
        _numbers(limit.get(bound), 1, f"{where}, <limit {bound}>", source)
    if float(limit.get("lower", "0")) > float(limit.get("upper", "0")):
        raise MalformedUrdfError(
            source, f"{where}: its lower limit {limit.get('lower')} is above its upper limit {limit.get('upper')}"
        )


def _repair_inertial(link: ElementTree.Element, source: str) -> Iterable[Repair]:
    inertial = link.find("inertial")
    if inertial is None:
        return
    where = f"link {link.get('name')!r}"
    mass_element, inertia_element = inertial.find("mass"), inertial.find("inertia")
    if mass_element is None:
        raise MalformedUrdfError(source, f"{where}: <inertial> without <mass>")
    if inertia_element is None:
        inertia_element = ElementTree.SubElement(inertial, "inertia")
    try:
        mass, inertia = float(mass_element.get("value", "")), read_inertia(inertia_element)
    except ValueError as error:
        raise MalformedUrdfError(
            source, f"{where}: its inertia holds something that is not a number: {error}"
        ) from error
    if not math.isfinite(mass) or mass <= 0.0:
        link.remove(inertial)
        # Zero of everything says no more than saying nothing, so it is no defect.
        if mass != 0.0 or np.any(inertia != 0.0):
            yield Repair(where, f"mass {mass:g} kg, inertia {_listed(inertia)} kg m2", "taken as massless")
        return
    if not np.isfinite(inertia).all():
        yield Repair(where, f"inertia {_listed(inertia)} kg m2", "taken as that of a point mass")
        inertia = np.zeros((3, 3))
    consistent = consistent_inertia(mass, inertia)
    if consistent is not inertia:
        write_inertia(inertia_element, consistent)
        change = float(np.linalg.norm(consistent - inertia))
        yield Repair(
            where,
            f"inertia {_listed(inertia)} kg m2 is that of no body",
            f"replaced by the nearest that is, {_listed(consistent)} kg m2 (changed by {change:.3g})",
        )


def _listed(inertia: np.ndarray) -> str:
    rows, columns = np.triu_indices(3)
    return "[" + " ".join(f"{value:.6g}" for value in inertia[rows, columns]) + "]"


def _give_mass_to_moved(
    links: dict[str, ElementTree.Element], joints: dict[str, ElementTree.Element]
) -> Iterable[Repair]:
    fixed_below: dict[str, list[str]] = {}
    for joint in joints.values():
        if joint.get("type") == "fixed":
            fixed_below.setdefault(_link_of(joint, "parent"), []).append(_link_of(joint, "child"))

    def has_mass(link: str) -> bool:
        return links[link].find("inertial") is not None or any(has_mass(child) for child in fixed_below.get(link, ()))

    for name, joint in joints.items():
        moved = _link_of(joint, "child")
        if joint.get("type") == "fixed" or has_mass(moved):
            continue
        inertial = ElementTree.SubElement(links[moved], "inertial")
        ElementTree.SubElement(inertial, "mass", value=repr(SMALLEST_MOVED_MASS_KG))
        write_inertia(ElementTree.SubElement(inertial, "inertia"), SMALLEST_MOVED_INERTIA_KG_M2 * np.eye(3))
        yield Repair(
            f"link {moved!r}",
            f"moved by joint {name!r} and without mass",
            f"given {SMALLEST_MOVED_MASS_KG:g} kg and {SMALLEST_MOVED_INERTIA_KG_M2:g} kg m2",
        )


def _resolve_meshes(link: ElementTree.Element, urdf_folder: Path, package_folders: Sequence[Path], source: str) -> None:
    name = link.get("name", "")
    for kind in ("visual", "collision"):
        for mesh in link.findall(f"{kind}/geometry/mesh"):
            path = find_mesh(name, mesh.get("filename", ""), urdf_folder, package_folders)
            scale = _numbers(mesh.get("scale", "1 1 1"), 3, f"link {name!r}, <mesh scale>", source)
            if not np.all(scale != 0.0):
                raise MalformedUrdfError(source, f"link {name!r}: <mesh scale={mesh.get('scale')!r}> flattens the mesh")
            if kind == "collision":
                path, scale = as_stl(path, scale), np.ones(3)
            mesh.set("filename", str(path))
            mesh.set("scale", " ".join(repr(float(factor)) for factor in scale))
