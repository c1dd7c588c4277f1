import dataclasses
from pathlib import Path

import mujoco
import numpy as np
import pytest
import rerun as rr
from recorder_samples import Entities, read_recording

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.eye import stand
from dr_lab.recorders.look import Look
from dr_lab.recorders.scene import log_bodies, log_surroundings, moving_corners, send_poses, thin
from dr_lab.recorders.shape import Paint, geom_shape

_SHAPES = """
<mujoco>
  <asset>
    <mesh name="first" vertex="0 0 0  1 0 0  0 1 0  0 0 1  1 1 1"/>
    <mesh name="wedge" vertex="0 0 0  1 0 0  0 2 0  0 0 3"/>
  </asset>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <geom name="wall" type="plane" size="2 3 1" pos="0 0 1" zaxis="1 0 0"/>
    <body name="robot" pos="0 0 1">
      <freejoint/>
      <geom name="capsule" type="capsule" size="0.1" fromto="1 0 0 1 0 4"/>
      <geom name="tilted" type="capsule" size="0.1" fromto="0 1 2 4 1 2"/>
      <geom name="cylinder" type="cylinder" size="0.1 0.7" pos="0 1 0"/>
      <geom name="box" type="box" size="0.1 0.2 0.3" quat="0.5 0.5 0.5 0.5"/>
      <geom name="ball" type="sphere" size="0.4"/>
      <geom name="egg" type="ellipsoid" size="0.1 0.2 0.3"/>
      <geom name="wedge" type="mesh" mesh="wedge" pos="0 0 5" euler="0 0 90"/>
      <geom name="contact" type="sphere" size="9" group="3"/>
      <geom name="glass" type="sphere" size="9" rgba="1 1 1 0"/>
      <geom type="sphere" size="0.1"/>
    </body>
  </worldbody>
</mujoco>
"""
_RED = (255, 0, 0, 110)
_PAINT = Paint(_RED)


@pytest.fixture(scope="module")
def shapes() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(_SHAPES)


def _field(model: mujoco.MjModel, geom: str, name: str, paint: Paint = _PAINT) -> np.ndarray:
    """One component of a geom's Rerun archetype as an array of numbers."""
    shape = geom_shape(model, model.geom(geom).id, paint)
    assert shape is not None
    batch = getattr(shape, name)
    return np.array(batch.as_arrow_array().to_pylist(), dtype=float)


def test_capsule_spans_its_end_points(shapes: mujoco.MjModel) -> None:
    for name, start, end in (("capsule", [1, 0, 0], [1, 0, 4]), ("tilted", [0, 1, 2], [4, 1, 2])):
        length, origin = _field(shapes, name, "lengths")[0], _field(shapes, name, "translations")[0]
        quaternion = _field(shapes, name, "quaternions")[0][[3, 0, 1, 2]]
        axis = np.empty(3)
        mujoco.mju_rotVecQuat(axis, np.array([0.0, 0.0, 1.0]), quaternion)
        ends = sorted([origin.round(6).tolist(), (origin + length * axis).round(6).tolist()])
        np.testing.assert_allclose(ends, sorted([start, end]), atol=1e-6)


def test_sizes_of_the_other_shapes(shapes: mujoco.MjModel) -> None:
    assert _field(shapes, "cylinder", "lengths") == pytest.approx(1.4)
    assert _field(shapes, "cylinder", "centers")[0] == pytest.approx([0, 1, 0])
    assert _field(shapes, "box", "half_sizes")[0] == pytest.approx([0.1, 0.2, 0.3])
    assert _field(shapes, "ball", "half_sizes")[0] == pytest.approx([0.4, 0.4, 0.4])
    assert _field(shapes, "egg", "half_sizes")[0] == pytest.approx([0.1, 0.2, 0.3])


def test_planes_are_slabs_below_their_surface(shapes: mujoco.MjModel) -> None:
    floor, wall = (_field(shapes, name, "half_sizes")[0] for name in ("floor", "wall"))
    assert (floor[:2] > shapes.stat.extent).all()
    assert wall[:2] == pytest.approx([2, 3])
    assert _field(shapes, "floor", "centers")[0] == pytest.approx([0, 0, -floor[2]])
    assert _field(shapes, "wall", "centers")[0] == pytest.approx([-wall[2], 0, 1])


def test_mesh_lies_where_mujoco_has_it(shapes: mujoco.MjModel) -> None:
    corners = _field(shapes, "wedge", "vertex_positions")
    # Turned by 90° about z and raised by 5: (x, y, z) → (−y, x, z + 5), about the mesh's own origin.
    expected = [[0, 0, 5], [0, 1, 5], [-2, 0, 5], [0, 0, 8]]
    assert sorted(corners.round(6).tolist()) == pytest.approx(np.array(sorted(expected)), abs=1e-6)


def test_a_ghost_is_larger_about_its_own_centre(shapes: mujoco.MjModel) -> None:
    ghost = Paint(_RED, swell=1.5)
    assert _field(shapes, "box", "half_sizes", ghost)[0] == pytest.approx([0.15, 0.3, 0.45])
    assert _field(shapes, "capsule", "lengths", ghost) == pytest.approx(6)
    assert np.abs(_field(shapes, "capsule", "translations", ghost)[0] - [1, 0, 2]) == pytest.approx([0, 0, 3])
    solid, swollen = (_field(shapes, "wedge", "vertex_positions", paint) for paint in (_PAINT, ghost))
    centre = shapes.geom_pos[shapes.geom("wedge").id]
    np.testing.assert_allclose(swollen - centre, 1.5 * (solid - centre), atol=1e-6)


def test_mesh_faces_are_its_own(shapes: mujoco.MjModel) -> None:
    faces = _field(shapes, "wedge", "triangle_indices")
    assert sorted(set(faces.ravel().tolist())) == [0, 1, 2, 3]


def test_thinning_keeps_the_first_of_each_interval() -> None:
    time = np.arange(1000) / 500
    kept = time[thin(time, 50)]
    np.testing.assert_allclose(kept, np.arange(100) / 50)
    gap = np.array([0.0, 0.001, 5.0, 5.001, 5.021])
    assert thin(gap, 50).tolist() == [0, 2, 4]
    assert thin(np.empty(0), 50).tolist() == []


def test_corners_of_every_moving_shape_at_every_time() -> None:
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><geom type="box" size="9 9 9"/><body pos="0 0 1"><joint type="slide" axis="1 0 0"/>'
        '<geom type="box" size="0.3 0.2 0.1" pos="0 1 0"/></body></worldbody></mujoco>'
    )
    position = np.zeros((3, 2, 3))
    position[:, 1] = [[-1, 0, 1], [2, 0, 1], [np.nan, 0, 1]]
    corners = moving_corners(model, position, np.tile([1.0, 0, 0, 0], (3, 2, 1)))
    assert len(corners) == 16
    np.testing.assert_allclose(corners.min(axis=0), [-1.3, 0.8, 0.9])
    np.testing.assert_allclose(corners.max(axis=0), [2.3, 1.2, 1.1])


def test_nothing_moves_in_a_fixed_model() -> None:
    fixed = mujoco.MjModel.from_xml_string('<mujoco><worldbody><geom type="sphere" size="2"/></worldbody></mujoco>')
    assert moving_corners(fixed, np.zeros((0, 1, 3)), np.zeros((0, 1, 4))).shape == (0, 3)


def test_eye_sees_all_points_and_one_at_the_edge(look: Look) -> None:
    points = np.random.default_rng(2).normal(size=(200, 3)) * [3.0, 1.0, 0.5] + [5.0, 0.0, 1.0]
    eye, target = stand(points, dataclasses.replace(look, margin=1.0))
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    depth = (points - eye) @ forward
    across, up = (np.abs((points - eye) @ axis) / depth for axis in (right, np.cross(right, forward)))
    half = np.tan(np.deg2rad(55 / 2))
    assert max(across.max() / (0.85 * half), up.max() / half) == pytest.approx(1.0)
    assert np.rad2deg(np.arcsin(-forward[2])) == pytest.approx(look.elevation)


@pytest.fixture
def read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, shapes: mujoco.MjModel) -> Entities:
    """What a recording of the shapes holds: entity → component → list of values."""
    monkeypatch.setenv("RERUN_STRICT", "1")
    recording = rr.RecordingStream("dr_lab_test")
    recording.save(tmp_path / "a.rrd")
    position = np.full((4, 2, 3), np.arange(4)[:, None, None], dtype=float)
    position[2, 1, 0] = np.nan
    turned = np.tile([0.5, 0.5, -0.5, 0.5], (4, 2, 1))
    root = Branch(recording, ("a:b", "world"))
    log_bodies(root / "real", shapes, _PAINT)
    log_surroundings(root / "fixed", shapes, _RED, _RED)
    send_poses(root / "real", shapes, np.arange(4) / 10, (position, turned))
    recording.disconnect()
    return read_recording(tmp_path / "a.rrd")


def test_recording_has_visible_shapes_only_and_names_all(read: Entities) -> None:
    world = "/a\\:b/world"
    names = ["capsule", "tilted", "cylinder", "box", "ball", "egg", "wedge", "geom_11"]
    assert {path for path in read if path.startswith(f"{world}/real/robot/")} == {
        f"{world}/real/robot/{name}" for name in names
    }
    assert {f"{world}/fixed/world/floor", f"{world}/fixed/world/wall"} < set(read)


def test_recording_has_poses_in_reruns_order_without_broken_rows(read: Entities) -> None:
    pose = read["/a\\:b/world/real/robot"]
    assert [row[0] for row in pose["Transform3D:translation"]] == [[0, 0, 0], [1, 1, 1], [3, 3, 3]]
    assert pose["Transform3D:quaternion"][0][0] == [0.5, -0.5, 0.5, 0.5]
    assert pose["t"] == [0.0, 0.1, 0.3]
