# SPDX-License-Identifier: Apache-2.0
"""Turns any URDF into one text from which every library builds the same robot, and lists what it changed."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from robotskin.model import UNBOUNDED
from robotskin.robots.errors import MalformedUrdfError
from robotskin.robots.inertia import consistent_inertia, read_inertia, write_inertia
from robotskin.robots.shapes import check_colour, resolve_shapes
from robotskin.robots.urdf_tree import check_origin, check_tree, link_of, named_elements, numbers, parse_urdf

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

    The models treat it as a joint of its own, so that both have the same joints; the robot's driver applies it.
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
    root = parse_urdf(text, source)
    for child in list(root):
        if child.tag not in ("link", "joint", "material"):
            root.remove(child)
    repairs: list[Repair] = []
    links = named_elements(root, "link", source)
    joints = named_elements(root, "joint", source)
    check_tree(links, joints, source)
    for material in root.iter("material"):
        check_colour(material, source)
    mimics = tuple(_free_mimic(joint, source) for joint in joints.values() if joint.find("mimic") is not None)
    for mimic in mimics:
        if mimic.source not in joints:
            repairs.append(
                Repair(f"joint {mimic.joint!r}", f"mimics {mimic.source!r}, no joint", "taken as not coupled")
            )
    mimics = tuple(mimic for mimic in mimics if mimic.source in joints)
    for joint in joints.values():
        repairs += _repair_joint(joint, source)
    for link in links.values():
        repairs += _repair_inertial(link, source)
        resolve_shapes(link, urdf_folder, package_folders, source)
    repairs += _give_mass_to_moved(links, joints)
    movable = {name for name, joint in joints.items() if joint.get("type") != "fixed"}
    mujoco = ElementTree.SubElement(root, "mujoco")
    ElementTree.SubElement(mujoco, "compiler", _MUJOCO_COMPILER)
    return RepairedUrdf(root, tuple(repairs), tuple(mimic for mimic in mimics if mimic.joint in movable))


def _free_mimic(joint: ElementTree.Element, source: str) -> Mimic:
    mimic = joint.find("mimic")
    assert mimic is not None
    joint.remove(mimic)
    name = joint.get("name", "")
    where = f"joint {name!r}, <mimic"
    multiplier = numbers(mimic.get("multiplier", "1"), 1, f"{where} multiplier>", source)
    offset = numbers(mimic.get("offset", "0"), 1, f"{where} offset>", source)
    return Mimic(name, mimic.get("joint", ""), float(multiplier[0]), float(offset[0]))


def _repair_joint(joint: ElementTree.Element, source: str) -> Iterable[Repair]:
    name, kind = joint.get("name", ""), joint.get("type")
    where = f"joint {name!r}"
    if kind not in ("revolute", "continuous", "prismatic", "fixed"):
        raise MalformedUrdfError(
            source, f"{where} is of type {kind!r}; a joint is revolute, continuous, prismatic or fixed"
        )
    check_origin(joint, where, source)
    for unused in (*joint.findall("safety_controller"), *joint.findall("calibration")):
        joint.remove(unused)
    if kind == "fixed":
        for tag in ("axis", "limit", "dynamics"):
            for element in joint.findall(tag):
                joint.remove(element)
        return
    axis = joint.find("axis")
    if axis is not None:
        direction = numbers(axis.get("xyz"), 3, f"{where}, <axis xyz>", source)
        length = float(np.linalg.norm(direction))
        if length < 1e-9:
            raise MalformedUrdfError(source, f"{where}: its axis is {axis.get('xyz')!r}, which has no direction")
        if abs(length - 1.0) > 1e-12:
            axis.set("xyz", " ".join(repr(float(part)) for part in direction / length))
        if abs(length - 1.0) > 1e-3:
            yield Repair(where, f"axis of length {length:.6g}", "made a unit vector")
    for dynamics in joint.findall("dynamics"):
        for attribute in dynamics.attrib:
            if numbers(dynamics.get(attribute), 1, f"{where}, <dynamics {attribute}>", source)[0] < 0.0:
                raise MalformedUrdfError(source, f"{where}: <dynamics {attribute}> is negative")
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
        numbers(limit.get(bound), 1, f"{where}, <limit {bound}>", source)
    if float(limit.get("lower", "0")) > float(limit.get("upper", "0")):
        raise MalformedUrdfError(
            source, f"{where}: its lower limit {limit.get('lower')} is above its upper limit {limit.get('upper')}"
        )
    if float(limit.get("lower", "0")) == float(limit.get("upper", "0")):
        yield Repair(where, f"lower and upper limit both {limit.get('lower')}", "taken as unbounded")
        limit.set("lower", repr(-UNBOUNDED))
        limit.set("upper", repr(UNBOUNDED))


def _repair_inertial(link: ElementTree.Element, source: str) -> Iterable[Repair]:
    inertial = link.find("inertial")
    if inertial is None:
        return
    where = f"link {link.get('name')!r}"
    check_origin(inertial, f"{where}, <inertial>", source)
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
            fixed_below.setdefault(link_of(joint, "parent"), []).append(link_of(joint, "child"))

    def has_mass(link: str) -> bool:
        return links[link].find("inertial") is not None or any(has_mass(child) for child in fixed_below.get(link, ()))

    for name, joint in joints.items():
        moved = link_of(joint, "child")
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
