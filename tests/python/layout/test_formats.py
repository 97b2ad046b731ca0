# SPDX-License-Identifier: Apache-2.0
"""Every format is told by its content and read into the same form; what is no skin is refused by name."""

import gzip
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from robotskin.layout import Layout, LayoutFileError, read
from robotskin.layout.cell import hinge_gaps

TUM_XML = """<?xml version="1.0"?><!DOCTYPE scfg>
<SkinConfig numberOfCells="1">
 <patchExtrinsics patchId="3" baseFrame="arm"><tf_rootCell_base><pos>{place}</pos><rot>{unit}</rot></tf_rootCell_base>
 </patchExtrinsics>
 <cell id="7" patch="3" segment="2"><rootCellId>7</rootCellId>
  <neighbors id="7" size="4"><neighbor port="2" id="9"/><neighbor port="4" id="16383"/></neighbors>
  <pos>{place}</pos><rot>{unit}</rot></cell>
</SkinConfig>"""

URDF = """<robot name="gripper"><link name="palm"><tactile name="pad"><origin xyz="0 0 0.5"/></tactile></link>
 <sensor name="grid"><parent link="palm"/><origin xyz="0.1 0 0" rpy="0 1.5707963267948966 0"/>
  <tactile><array rows="2" cols="3" size="0.004 0.005" offset="0.001 0"/></tactile></sensor>
 <sensor name="list"><parent link="palm"/><tactile><taxel idx="4" xyz="0 0.01 0" rpy="0 0 0"/></tactile></sensor>
</robot>"""

ICUB = """name r_hand
spatial_sampling taxel
taxel2Repr (0 0 -1)
[calibration]
0.01 0.02 0.03 0 0 1
0.01 0.03 0.03 0 0 1
0 0 0 0 0 0
"""


def matrix(values: np.ndarray) -> str:
    elements = (f'<element row="{r}" col="{c}">{values[r, c]}</element>' for r, c in np.ndindex(values.shape))
    return f'<matrix rows="{values.shape[0]}" cols="{values.shape[1]}">{"".join(elements)}</matrix>'


def test_tum_json(tum_file: Callable[..., Path]) -> None:
    skin = read(tum_file(first_id=5))
    assert (skin.format, len(skin.cells), skin.defects, skin.measured) == ("TUM skin JSON", 4, [], True)
    assert [cell.id for cell in skin.cells] == [5, 6, 7, 8]
    assert skin.cells[1].neighbours == (7, 0, 0, 5)
    assert skin.cells[1].link == "foot"


def test_tum_xml_chains_the_patch_into_its_frame(tmp_path: Path) -> None:
    file = tmp_path / "skin.xml"
    file.write_text(TUM_XML.format(place=matrix(np.array([[0.1], [0.2], [0.3]])), unit=matrix(np.eye(3))))
    (cell,) = read(file).cells
    assert (cell.id, cell.group, cell.patch, cell.link) == (7, 2, 3, "arm")
    np.testing.assert_allclose(cell.position, [0.2, 0.4, 0.6])
    assert cell.neighbours == (0, 9, 0, 16383)


def test_urdf_sensors(tmp_path: Path) -> None:
    file = tmp_path / "gripper.urdf"
    file.write_text(URDF)
    skin = read(file)
    assert len(skin.cells) == 8
    grid = [cell for cell in skin.cells if cell.where.startswith("grid")]
    assert [cell.id for cell in grid] == list(range(6))
    # The sensor is turned about y: its normal is the link's x, its rows run along the link's -z.
    np.testing.assert_allclose(grid[0].normal, [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(grid[4].position, [0.1, 0.005, -0.005], atol=1e-12)
    pad = next(cell for cell in skin.cells if "pad" in cell.where)
    np.testing.assert_allclose(pad.position, [0, 0, 0.5])


def test_icub_text(tmp_path: Path) -> None:
    file = tmp_path / "hand.txt"
    file.write_text(ICUB)
    skin = read(file)
    assert (len(skin.cells), skin.empty, skin.defects) == (2, 1, [])
    assert skin.cells[1].where == "row 1"
    assert skin.cells[1].link == "r_hand"


def test_own_layout_is_found_as_it_is(strip: Layout, tmp_path: Path) -> None:
    strip.save(tmp_path / "skin.json.gz")
    assert gzip.decompress((tmp_path / "skin.json.gz").read_bytes()).startswith(b"{")
    skin = read(tmp_path / "skin.json.gz")
    assert skin.defects == []
    np.testing.assert_array_equal(skin.positions(), strip.link_from_cell[:, :3, 3])
    assert skin.cells[1].neighbours == (3, 0, 0, 1)
    assert skin.cells[1].neighbour_ports == (4, 0, 0, 1)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"# a text",
        b"{",
        b"[1, 2]",
        b'{"a": 1}',
        b"<a",
        b"<a/>",
        b"\xff\xfe\x00",
        b"\x1f\x8bnot gzip",
        b'{"sc_patch": 3}',
    ],
)
def test_what_is_no_skin_is_refused(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "thing"
    file.write_bytes(content)
    with pytest.raises(LayoutFileError, match="thing"):
        read(file)


def test_published_tum_patches(shared_data: Path) -> None:
    """Tree edges obey the hinge rule; the six edges that close a loop are off as measured by others."""
    gaps = []
    for file in sorted((shared_data / "tum_patches").glob("p?e.json")):
        skin = read(file)
        poses = np.tile(np.eye(4), (len(skin.cells), 1, 1))
        index = {cell.id: i for i, cell in enumerate(skin.cells)}
        for i, cell in enumerate(skin.cells):
            poses[i, :3, :3], poses[i, :3, 3] = cell.rotation, cell.position
        edges = [
            (i, port, index[other], skin.cells[index[other]].neighbours.index(cell.id))
            for i, cell in enumerate(skin.cells)
            for port, other in enumerate(cell.neighbours)
            if other in index and i < index[other]
        ]
        gaps.append(hinge_gaps(poses, *np.array(edges).T))
    every = np.sort(np.concatenate(gaps))
    assert len(every) == 30
    assert np.all(every[:-6] < 1e-5)
    assert np.isclose(every[-6:].mean(), 1.65e-3, atol=2e-5)
