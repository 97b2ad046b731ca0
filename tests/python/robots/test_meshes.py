# SPDX-License-Identifier: Apache-2.0
"""Surfaces are where both models have them, and converted files are kept whole and once."""

import itertools
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from robotskin.robots import from_text, load
from robotskin.robots.meshes import as_stl, cache_folder, find_mesh


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "robotskin" / "meshes"


def points_of(model: mujoco.MjModel, geom: int) -> np.ndarray:
    """(k, 3) points that span a geom, in its frame."""
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    circle = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    size = model.geom_size[geom]
    match model.geom_type[geom]:
        case mujoco.mjtGeom.mjGEOM_MESH:
            mesh = model.mesh(model.geom_dataid[geom])
            return model.mesh_vert[mesh.vertadr[0] : mesh.vertadr[0] + mesh.vertnum[0]]
        case mujoco.mjtGeom.mjGEOM_BOX:
            return np.array(list(itertools.product([-1.0, 1.0], repeat=3))) * size
        case mujoco.mjtGeom.mjGEOM_CYLINDER:
            return np.concatenate([size[0] * circle + [0.0, 0.0, end] for end in (-size[1], size[1])])
        case mujoco.mjtGeom.mjGEOM_SPHERE:
            return size[0] * np.concatenate([np.roll(circle, shift, axis=1) for shift in range(3)])
    raise AssertionError(model.geom_type[geom])


def mujoco_bounds(model: mujoco.MjModel, link: str) -> np.ndarray:
    """(2, 3) bounds of a link's geoms in its frame."""
    points = []
    for geom in np.flatnonzero(model.geom_bodyid == model.body(link).id):
        turn = np.empty(9)
        mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
        points.append(points_of(model, geom) @ turn.reshape(3, 3).T + model.geom_pos[geom])
    stacked = np.concatenate(points)
    return np.array([stacked.min(axis=0), stacked.max(axis=0)])


@pytest.mark.parametrize("name", ["ur5", "panda", "allegro_right_hand", "talos", "dual_arm"])
def test_the_surface_of_a_link_is_what_mujoco_touches(name: str) -> None:
    robot = load(name)
    model = robot.mujoco_model()
    assert len(robot.links_with("collision")) > 5
    for link in robot.links_with("collision"):
        types = set(model.geom_type[model.geom_bodyid == model.body(link).id])
        # Round bodies become triangles, which lie inside them.
        flat = types <= {mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_BOX}
        bounds, touched = robot.link_mesh(link).bounds, mujoco_bounds(model, link)
        np.testing.assert_allclose(bounds, touched, atol=1e-6 if flat else 5e-4, err_msg=link)


@pytest.mark.parametrize("name", ["ur5", "talos"])
def test_what_is_seen_is_where_what_is_touched_is(name: str) -> None:
    robot = load(name)
    for link in set(robot.links_with("collision")) & set(robot.links_with("visual")):
        touched, seen = robot.link_mesh(link).bounds, robot.link_mesh(link, "visual").bounds
        assert np.abs(touched - seen).max() < 0.3 * np.ptp(touched, axis=0).max(), link


def test_simple_bodies_and_origins(tmp_path: Path) -> None:
    shapes = {
        '<box size="0.2 0.4 0.6"/>': [0.6, 0.4, 0.2],
        '<cylinder radius="0.1" length="0.6"/>': [0.6, 0.2, 0.2],
        '<sphere radius="0.1"/>': [0.2, 0.2, 0.2],
    }
    for shape, extents in shapes.items():
        # A quarter turn about y puts the body's z along x.
        origin = '<origin xyz="1 2 3" rpy="0 1.5707963267948966 0"/>'
        part = f"<collision>{origin}<geometry>{shape}</geometry></collision>"
        robot = from_text(f'<robot name="b"><link name="base">{part}</link></robot>', name="b", folder=tmp_path)
        bounds = robot.link_mesh("base").bounds
        np.testing.assert_allclose(bounds.mean(axis=0), [1.0, 2.0, 3.0], atol=1e-9)
        np.testing.assert_allclose(np.ptp(bounds, axis=0), extents, atol=0.002)


def test_a_part_turned_about_all_axes_is_where_mujoco_has_it(tmp_path: Path) -> None:
    part = '<collision><origin rpy="0.3 0.5 0.7"/><geometry><box size="0.2 0.4 0.6"/></geometry></collision>'
    robot = from_text(f'<robot name="b"><link name="base">{part}</link></robot>', name="b", folder=tmp_path)
    np.testing.assert_allclose(robot.link_mesh("base").bounds, mujoco_bounds(robot.mujoco_model(), "base"), atol=1e-9)


def test_a_mirrored_mesh_keeps_its_outside(tmp_path: Path, cache: Path) -> None:
    box = trimesh.creation.box(extents=(1.0, 2.0, 3.0))
    box.apply_translation([5.0, 0.0, 0.0])
    box.export(tmp_path / "box.stl")
    mirrored = trimesh.load_mesh(as_stl(tmp_path / "box.stl", np.array([-1.0, 1.0, 0.5])))
    assert mirrored.volume == pytest.approx(3.0)
    np.testing.assert_allclose(mirrored.bounds, [[-5.5, -1.0, -0.75], [-4.5, 1.0, 0.75]], atol=1e-6)


def test_a_converted_file_is_made_once_and_follows_its_source(tmp_path: Path, cache: Path) -> None:
    source = tmp_path / "part.obj"
    trimesh.creation.box(extents=(1.0, 1.0, 1.0)).export(source)
    first = as_stl(source, np.ones(3))
    made = first.stat().st_mtime_ns
    assert first.parent == cache == cache_folder()
    assert as_stl(source, np.ones(3)) == first
    assert first.stat().st_mtime_ns == made
    assert as_stl(source, 2.0 * np.ones(3)) != first
    trimesh.creation.box(extents=(2.0, 1.0, 1.0)).export(source)
    changed = as_stl(source, np.ones(3))
    assert changed != first
    np.testing.assert_allclose(trimesh.load_mesh(changed).extents, [2.0, 1.0, 1.0])
    assert sorted(path.suffix for path in cache.iterdir()) == [".stl"] * 3, "a half-written file was left behind"


def test_a_failed_conversion_leaves_nothing(tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = tmp_path / "part.obj"
    trimesh.creation.box().export(source)
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        as_stl(source, np.ones(3))
    assert list(cache.iterdir()) == []


def test_a_binary_stl_is_used_as_it_is(tmp_path: Path, cache: Path) -> None:
    trimesh.creation.box().export(tmp_path / "box.stl")
    assert as_stl(tmp_path / "box.stl", np.ones(3)) == tmp_path / "box.stl"
    assert not cache.exists()


def test_packages_are_found_where_ros_looks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "somewhere" / "their_robot"
    (package / "meshes").mkdir(parents=True)
    mesh = package / "meshes" / "arm.stl"
    mesh.write_bytes(b"")
    elsewhere = tmp_path / "elsewhere"
    for address in ("package://their_robot/meshes/arm.stl", "package:///their_robot/meshes/arm.stl"):
        for folder in (package, package.parent):
            assert find_mesh("arm", address, elsewhere, [folder]) == mesh
            monkeypatch.setenv("ROS_PACKAGE_PATH", str(folder))
            assert find_mesh("arm", address, elsewhere, []) == mesh
            monkeypatch.delenv("ROS_PACKAGE_PATH")
        assert find_mesh("arm", address, package / "urdf", []) == mesh
    (package / "urdf").mkdir()
    assert find_mesh("arm", "../meshes/arm.stl", package / "urdf", []) == mesh
    assert find_mesh("arm", mesh.as_uri(), elsewhere, []) == mesh
