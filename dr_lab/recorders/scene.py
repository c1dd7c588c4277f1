"""A MuJoCo model as Rerun geometry: static shapes below one moving frame a body."""

import itertools
from collections.abc import Sequence

import mujoco
import numpy as np
import rerun as rr
from scipy.spatial.transform import Rotation

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.shape import Colour, Paint, geom_shape
from dr_lab.trajectory import Array

# MuJoCo's own viewer shows groups 0, 1 and 2 and hides the rest, where collision shapes usually are.
_SHOWN_GROUPS = 3


def log_bodies(root: Branch, model: mujoco.MjModel, paint: Paint) -> None:
    """Log the shapes of the bodies that can move, below ``<root>/<body>/<geom>``.

    Args:
        root: where the robot is.
        model: geometry, sizes in m; height fields and invisible or collision-only geoms (group > 2) are not drawn.
        paint: how every shape is drawn.
    """
    for geom in _visible_geoms(model):
        if not _is_fixed(model, geom):
            _log_shape(root / _body_name(model, model.geom_bodyid[geom]), model, geom, paint)


def log_surroundings(root: Branch, model: mujoco.MjModel, ground: Colour, fixed: Colour) -> None:
    """Log the shapes of the bodies fixed to the world, at rest, below ``<root>/<body>/<geom>``.

    Args:
        root: where they are.
        model: geometry, sizes in m.
        ground: colour of planes.
        fixed: colour of everything else.
    """
    rest = mujoco.MjData(model)
    mujoco.mj_kinematics(model, rest)
    for geom in filter(lambda geom: _is_fixed(model, geom), _visible_geoms(model)):
        body = model.geom_bodyid[geom]
        place = root / _body_name(model, body)
        place.static(rr.Transform3D(translation=rest.xpos[body], quaternion=np.roll(rest.xquat[body], -1)))
        is_plane = model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE
        _log_shape(place, model, geom, Paint(ground if is_plane else fixed))


def send_poses(root: Branch, model: mujoco.MjModel, time: Array, pose: tuple[Array, Array]) -> None:
    """Send the frames of the moving bodies that have shapes.

    Args:
        root: where the robot is.
        model: names of the bodies and which of them move.
        time: s, shape (n,).
        pose: world positions in m, shape (n, nbody, 3), and orientations wxyz, shape (n, nbody, 4); rows with a value
            that is not finite are skipped.
    """
    for body in _moving_bodies(model):
        position, quaternion = pose[0][:, body], np.roll(pose[1][:, body], -1, axis=-1)
        finite = np.isfinite(position).all(axis=-1) & np.isfinite(quaternion).all(axis=-1)
        columns = rr.Transform3D.columns(translation=position[finite], quaternion=quaternion[finite])
        if finite.any():
            (root / _body_name(model, body)).over_time(time[finite], columns)


def send_start(root: Branch, model: mujoco.MjModel, pose: tuple[Array, Array], timeline: str) -> None:
    """Put the moving bodies into the first of the poses at 0 of a timeline that counts; arguments as `send_poses`."""
    for body in _moving_bodies(model):
        translation, quaternion = pose[0][:1, body], np.roll(pose[1][:1, body], -1, axis=-1)
        columns = rr.Transform3D.columns(translation=translation, quaternion=quaternion)
        (root / _body_name(model, body)).over(timeline, np.zeros(1, int), columns)


def body_poses(model: mujoco.MjModel, qpos: Array, bodies: Sequence[int] | None = None) -> tuple[Array, Array]:
    """World poses of bodies at the given positions.

    Args:
        model: the machine.
        qpos: shape (n, nq).
        bodies: k of the model's bodies; None takes all.

    Returns:
        Positions in m, shape (n, k, 3), and orientations wxyz, shape (n, k, 4).
    """
    data = mujoco.MjData(model)
    chosen = np.arange(model.nbody) if bodies is None else np.asarray(bodies)
    position, orientation = np.empty((len(qpos), len(chosen), 3)), np.empty((len(qpos), len(chosen), 4))
    for row, values in enumerate(qpos):
        data.qpos[:] = values
        mujoco.mj_kinematics(model, data)
        position[row], orientation[row] = data.xpos[chosen], data.xquat[chosen]
    return position, orientation


def thin(time: Array, rate: float) -> np.ndarray:
    """Indices of at most `rate` samples a second, shape (k,): the first of each interval of 1/`rate` s."""
    # A thousandth of an interval keeps samples that lie on an edge from falling to either side by rounding.
    interval = np.floor((time - time[:1]) * rate + 1e-3)
    return np.unique(interval, return_index=True)[1]


def moving_corners(model: mujoco.MjModel, position: Array, quaternion: Array) -> Array:
    """Corners of the boxes around all moving shapes at all times, m, shape (k, 3); empty where nothing moves.

    Args:
        model: shapes.
        position: world positions of the bodies in m, shape (n, nbody, 3); rows that are not finite are left out.
        quaternion: their orientations wxyz, shape (n, nbody, 4).
    """
    geoms = [geom for geom in _visible_geoms(model) if not _is_fixed(model, geom)]
    finite = np.isfinite(position).all(axis=(1, 2)) & np.isfinite(quaternion).all(axis=(1, 2))
    if not geoms or not finite.any():
        return np.empty((0, 3))
    return np.concatenate([_placed_corners(model, geom, position[finite], quaternion[finite]) for geom in geoms])


def _placed_corners(model: mujoco.MjModel, geom: int, position: Array, quaternion: Array) -> Array:
    """Corners of a geom's bounding box in the world, over all poses of its body, shape (8 n, 3)."""
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    box = model.geom_aabb[geom][:3] + signs * model.geom_aabb[geom][3:]
    at_body = Rotation.from_quat(model.geom_quat[geom], scalar_first=True).apply(box) + model.geom_pos[geom]
    body = int(model.geom_bodyid[geom])
    turn = Rotation.from_quat(quaternion[:, body], scalar_first=True)
    return np.concatenate([turn.apply(corner) + position[:, body] for corner in at_body])


def _visible_geoms(model: mujoco.MjModel) -> list[int]:
    opaque = (model.geom_rgba[:, 3] > 0) | (model.geom_matid >= 0)
    return np.flatnonzero(opaque & (model.geom_group < _SHOWN_GROUPS)).tolist()


def _moving_bodies(model: mujoco.MjModel) -> list[int]:
    """Those that have visible shapes."""
    return sorted({int(model.geom_bodyid[geom]) for geom in _visible_geoms(model) if not _is_fixed(model, geom)})


def _is_fixed(model: mujoco.MjModel, geom: int) -> bool:
    return model.body_weldid[model.geom_bodyid[geom]] == 0


def _log_shape(place: Branch, model: mujoco.MjModel, geom: int, paint: Paint) -> None:
    shape = geom_shape(model, geom, paint)
    if shape is not None:
        (place / (model.geom(geom).name or f"geom_{geom}")).static(shape)


def _body_name(model: mujoco.MjModel, body: int) -> str:
    return model.body(body).name or f"body_{body}"
