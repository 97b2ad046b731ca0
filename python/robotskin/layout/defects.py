# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a skin: one small check a kind of defect, each naming the cell, the value and why."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from robotskin import firmware
from robotskin.layout.cell import HINGE_REACH_M, LATTICE_PITCH_M, PORT_POINTS_M, PORTS
from robotskin.layout.raw_layout import Defect, RawCell, RawLayout
from robotskin.layout.surface import DistanceField

Array = NDArray[np.float64]

NORMAL_TOLERANCE = 0.02
"""Deviation from length 1 that rounding to three decimals can cause."""
PLACEHOLDER_SHARE = 0.5
"""Share of cells with one and the same normal from which on it looks like a placeholder."""
PLACEHOLDER_DEPTH_M = 0.005
"""Extent along that normal above which cells cannot lie in one plane."""
MEASURED_GAP_M = 0.001
"""Hinge gap beyond which a reconstructed pose is called wrong; planned skins may use the joint's whole reach."""
INSIDE_M = 0.001
LARGEST_LINK_M = 5.0
SMALLEST_SPACING_M = 1e-4
"""Taxels of any known skin are farther apart."""

NO_SIZES: Mapping[str, float] = MappingProxyType({})


def _text(values: Iterable[float]) -> str:
    return " ".join(f"{value:.4g}" for value in values)


def finite(skin: RawLayout) -> Iterator[Defect]:
    """Numbers that are none."""
    for cell in skin.cells:
        values = np.concatenate([cell.position, cell.normal])
        if not np.isfinite(values).all():
            yield Defect("not_finite", cell.where, _text(values), "position and normal must be finite numbers")


def normals(skin: RawLayout) -> Iterator[Defect]:
    """Normals without direction, or not of length 1, and rotations that are none."""
    for cell in skin.cells:
        length = float(np.linalg.norm(cell.normal))
        if length < 1e-6:
            yield Defect("zero_normal", cell.where, _text(cell.normal), "a normal of length zero gives no direction")
        elif abs(length - 1) > NORMAL_TOLERANCE:
            yield Defect("normal_length", cell.where, f"{length:.4g}", "a normal has length 1")
        if cell.rotation is not None and np.isfinite(cell.rotation).all():
            error = float(np.abs(cell.rotation @ cell.rotation.T - np.eye(3)).max())
            if error > 1e-3:
                yield Defect("not_a_rotation", cell.where, f"{error:.3g}", "error of rows that must be orthonormal")
            elif np.linalg.det(cell.rotation) < 0:
                yield Defect("not_a_rotation", cell.where, "determinant -1", "a mirror image; determinant must be 1")


def placeholder_normals(skin: RawLayout) -> Iterator[Defect]:
    """One normal for cells that cannot lie in one plane."""
    good = [cell for cell in skin.cells if np.isfinite(cell.normal).all() and np.linalg.norm(cell.normal) > 1e-6]
    by_link: dict[str, list[RawCell]] = defaultdict(list)
    for cell in good:
        by_link[cell.link].append(cell)
    for cells in by_link.values():
        (normal, count), *_ = Counter(tuple(np.round(cell.normal, 6)) for cell in cells).most_common(1)
        if count < 4 or count < PLACEHOLDER_SHARE * len(cells):
            continue
        same = [cell for cell in cells if tuple(np.round(cell.normal, 6)) == normal]
        depth = float(np.ptp([cell.position @ np.array(normal) for cell in same]))
        if depth > PLACEHOLDER_DEPTH_M:
            why = f"{count} of {len(cells)} cells have this normal although they extend {1e3 * depth:.0f} mm along it"
            for cell in same:
                yield Defect("placeholder_normal", cell.where, _text(normal), why)


def identities(skin: RawLayout) -> Iterator[Defect]:
    """Ids that occur twice or that the wire cannot carry, and cells at the same place."""
    seen: dict[tuple[int, int], str] = {}
    for cell in skin.cells:
        if cell.id is None:
            continue
        if (cell.group, cell.id) in seen:
            first = seen[cell.group, cell.id]
            yield Defect(
                "duplicate_id", cell.where, str(cell.id), f"the same id as {first} in section-unit group {cell.group}"
            )
        seen.setdefault((cell.group, cell.id), cell.where)
        if cell.neighbours and not firmware.ID_FIRST <= cell.id <= firmware.ID_LAST:
            yield Defect("id_range", cell.where, str(cell.id), f"ids are {firmware.ID_FIRST} to {firmware.ID_LAST}")
    positions = skin.positions()
    for link in {cell.link for cell in skin.cells}:
        here = [i for i, cell in enumerate(skin.cells) if cell.link == link and np.isfinite(cell.position).all()]
        if len(here) > 1:
            named = set()
            for a, b in sorted(cKDTree(positions[here]).query_pairs(SMALLEST_SPACING_M)):
                first, second = skin.cells[here[a]], skin.cells[here[b]]
                if b in named:
                    continue
                named.add(b)
                yield Defect("same_place", second.where, _text(second.position), f"the same place as {first.where}")


def neighbours(skin: RawLayout, elsewhere: frozenset[int] = frozenset()) -> Iterator[Defect]:
    """Neighbours that do not exist, do not know of each other, or meet at ports that cannot meet.

    Args:
        skin: of a format with neighbours.
        elsewhere: ids in the other files of the same skin.
    """
    by_id = {(cell.group, cell.id): cell for cell in skin.cells}
    for cell in skin.cells:
        used = [other for other in cell.neighbours if other not in (firmware.ID_NONE, firmware.ID_SECTION_UNIT)]
        for other in {other for other in used if used.count(other) > 1}:
            yield Defect("port_mismatch", cell.where, f"neighbour {other}", f"on {used.count(other)} of its ports")
        for port, other in enumerate(cell.neighbours, start=1):
            if other in (firmware.ID_NONE, firmware.ID_SECTION_UNIT):
                continue
            at = f"{cell.where}, port {port}"
            neighbour = by_id.get((cell.group, other))
            if other == cell.id:
                yield Defect("port_mismatch", at, f"neighbour {other}", "a cell cannot be its own neighbour")
            elif neighbour is None:
                if other not in elsewhere:
                    shown = f"neighbour {other}" if other > 0 else f"index {-other - 1}"
                    yield Defect("unknown_neighbour", at, shown, "no such cell here (a cell of another patch or file?)")
            elif cell.id not in neighbour.neighbours:
                yield Defect(
                    "one_way_neighbour", at, f"neighbour {other}", f"{neighbour.where} does not list this cell"
                )
            else:
                yield from _ports(cell, port, neighbour, at)


def _ports(cell: RawCell, port: int, neighbour: RawCell, at: str) -> Iterator[Defect]:
    """The port that the cell states for its neighbour must be the one on which the neighbour lists it."""
    stated = cell.neighbour_ports[port - 1]
    listed = [index for index, other in enumerate(neighbour.neighbours, start=1) if other == cell.id]
    if stated and stated not in listed:
        why = f"{neighbour.where} lists this cell on port {', '.join(map(str, listed))}"
        yield Defect("port_mismatch", at, f"port {stated} of neighbour {neighbour.id}", why)


def hinges(skin: RawLayout) -> Iterator[Defect]:
    """Edges whose hinge points are apart, and edges that would close if other ports had been listed."""
    limit = MEASURED_GAP_M if skin.measured else HINGE_REACH_M
    by_id = {(cell.group, cell.id): cell for cell in skin.cells}
    for cell in skin.cells:
        for port, other in enumerate(cell.neighbours, start=1):
            neighbour = by_id.get((cell.group, other))
            if neighbour is None or neighbour.id is None or cell.id is None or neighbour.id <= cell.id:
                continue
            if cell.id not in neighbour.neighbours or (cell.patch, cell.link) != (neighbour.patch, neighbour.link):
                continue
            gaps = _gap_table(cell, neighbour)
            if gaps is None:
                continue
            back = neighbour.neighbours.index(cell.id) + 1
            gap = gaps[port - 1, back - 1]
            at = f"{cell.where} port {port} - {neighbour.where} port {back}"
            if gap > limit:
                if gaps.min() <= limit:
                    best = np.unravel_index(int(np.argmin(gaps)), gaps.shape)
                    why = f"ports {best[0] + 1} and {best[1] + 1} would meet within {1e3 * gaps.min():.2f} mm"
                    yield Defect("port_mismatch", at, f"gap {1e3 * gap:.2f} mm", why)
                else:
                    why = f"hinge points are to meet within {1e3 * limit:.1f} mm (t = a_p - R a_q)"
                    yield Defect("hinge_gap", at, f"{1e3 * gap:.2f} mm", why)


def _gap_table(cell: RawCell, neighbour: RawCell) -> Array | None:
    """(4, 4) distance between each port point of the one and each of the other, metres."""
    if cell.rotation is None or neighbour.rotation is None:
        return None
    first = cell.position + PORT_POINTS_M @ cell.rotation.T
    second = neighbour.position + PORT_POINTS_M @ neighbour.rotation.T
    gaps = np.linalg.norm(first[:, None] - second[None], axis=2)
    return gaps if np.isfinite(gaps).all() and len(gaps) == PORTS else None


def units(skin: RawLayout, link_size: Mapping[str, float] = NO_SIZES) -> Iterator[Defect]:
    """Lengths that are right only after a factor of 1000.

    The evidence, strongest first: the distance of neighbours against the lattice pitch, the extent of a link's cells
    against its mesh, and sizes that no robot has.

    Args:
        skin: what the file says.
        link_size: diagonal of each known link's mesh, metres.
    """
    by_id = {(cell.group, cell.id): cell for cell in skin.cells}
    spacing = []
    for cell in skin.cells:
        for other in cell.neighbours:
            neighbour = by_id.get((cell.group, other))
            if neighbour is not None and neighbour is not cell and neighbour.link == cell.link:
                spacing.append(float(np.linalg.norm(cell.position - neighbour.position)))
    by_link: dict[str, list[Array]] = defaultdict(list)
    for cell in skin.cells:
        if np.isfinite(cell.position).all():
            by_link[cell.link].append(cell.position)
    if spacing:
        middle = float(np.median(spacing))
        if not LATTICE_PITCH_M / 30 < middle < LATTICE_PITCH_M * 30:
            yield Defect("units", "file", f"neighbours {middle:.4g} apart", _factor(middle / LATTICE_PITCH_M))
            return
    for link, places in by_link.items():
        points = np.array(places)
        extent = float(np.abs(points).max())
        expected = link_size.get(link)
        if expected is not None and not expected / 100 < extent < expected * 30:
            yield Defect("units", f"link {link}", f"extent {extent:.4g}", _factor(extent / expected))
        elif extent > LARGEST_LINK_M:
            yield Defect("units", f"link {link}", f"extent {extent:.4g}", _factor(1000.0))
        elif len(points) > 3 and not spacing:
            nearest = cKDTree(points).query(points, k=2)[0][:, 1]
            if 0 < float(np.median(nearest)) < SMALLEST_SPACING_M:
                value = f"cells {np.median(nearest):.3g} apart"
                yield Defect("units", f"link {link}", value, _factor(0.001))


def _factor(ratio: float) -> str:
    direction = "too large: millimetres where metres are due?" if ratio > 1 else "too small: kilometres for metres?"
    return f"about a factor of 1000 {direction}"


def inside_mesh(skin: RawLayout, field_of: Callable[[str], DistanceField | None]) -> Iterator[Defect]:
    """Cells whose face lies below the surface of the link they are on.

    Args:
        skin: what the file says.
        field_of: signed distance to a link's mesh, None for a link that the robot does not have.
    """
    for link in dict.fromkeys(cell.link for cell in skin.cells):
        field = field_of(link)
        if field is None:
            yield Defect("unknown_link", f"link {link}", skin.robot or "", "the robot has no such link with a mesh")
            continue
        cells = [cell for cell in skin.cells if cell.link == link and np.isfinite(cell.position).all()]
        depth = -field.at(np.array([cell.position for cell in cells]))
        for cell, value in zip(cells, depth, strict=True):
            if value > INSIDE_M:
                yield Defect("inside_mesh", cell.where, f"{1e3 * value:.1f} mm", f"below the surface of {link}")


def defects(
    skin: RawLayout,
    *,
    elsewhere: frozenset[int] = frozenset(),
    field_of: Callable[[str], DistanceField | None] | None = None,
    link_size: Mapping[str, float] = NO_SIZES,
) -> list[Defect]:
    """Every defect of a skin, those met while reading first.

    Args:
        skin: as read by `robotskin.layout.formats.read`.
        elsewhere: ids of cells in the other files of the same skin.
        field_of: distance to the mesh of a link of the robot, if that is known.
        link_size: diagonal of each known link's mesh, metres.
    """
    found = list(skin.defects)
    wrong_units = list(units(skin, link_size))
    found += wrong_units
    for check in (finite, normals, placeholder_normals, identities):
        found += check(skin)
    found += neighbours(skin, elsewhere)
    # With wrong units every distance is wrong, and saying so for each cell would bury the cause.
    if not wrong_units:
        found += hinges(skin)
        if field_of is not None:
            found += inside_mesh(skin, field_of)
    return found
