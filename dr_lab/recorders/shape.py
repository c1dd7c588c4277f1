"""One MuJoCo geom as a Rerun shape in the frame of its body."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import rerun as rr
from scipy.spatial.transform import Rotation

from dr_lab.trajectory import Array

Colour = tuple[int, int, int, int]

# A plane may be infinite and has no thickness: it is drawn as a slab, in units of the model's extent.
_SLAB_THICKNESS = 0.005
_SLAB_HALF_WIDTH = 1.5


@dataclass(frozen=True)
class Paint:
    """How a shape is drawn.

    Attributes:
        colour: red, green, blue, alpha, each 0 … 255; below an alpha of 255 the shape is seen through.
        swell: factor on the shape's size about its own centre; a ghost slightly larger than the solid that it lies
            upon tints it evenly, where equal surfaces would flicker.
    """

    colour: Colour
    swell: float = 1.0


def geom_shape(model: mujoco.MjModel, geom: int, paint: Paint) -> rr.AsComponents | None:
    """The solid shape of a geom, in m, or None for a kind that Rerun cannot draw (height field).

    Args:
        model: where the geom is.
        geom: its index.
        paint: colour and size.
    """
    look = {"colors": [paint.colour], "fill_mode": "solid", "quaternions": [np.roll(model.geom_quat[geom], -1)]}
    match mujoco.mjtGeom(model.geom_type[geom]):
        case mujoco.mjtGeom.mjGEOM_PLANE:
            return _slab(model, geom, look)
        case mujoco.mjtGeom.mjGEOM_MESH | mujoco.mjtGeom.mjGEOM_SDF:
            return _mesh(model, geom, paint)
        case _:
            return _primitive(model, geom, paint.swell, look)


def _primitive(model: mujoco.MjModel, geom: int, swell: float, look: Mapping[str, Any]) -> rr.AsComponents | None:
    size, at = swell * model.geom_size[geom], model.geom_pos[geom]
    match mujoco.mjtGeom(model.geom_type[geom]):
        case mujoco.mjtGeom.mjGEOM_SPHERE:
            return rr.Ellipsoids3D(half_sizes=[[size[0]] * 3], centers=[at], **look)
        case mujoco.mjtGeom.mjGEOM_ELLIPSOID:
            return rr.Ellipsoids3D(half_sizes=[size], centers=[at], **look)
        case mujoco.mjtGeom.mjGEOM_BOX:
            return rr.Boxes3D(half_sizes=[size], centers=[at], **look)
        case mujoco.mjtGeom.mjGEOM_CYLINDER:
            return rr.Cylinders3D(lengths=[2 * size[1]], radii=[size[0]], centers=[at], **look)
        case mujoco.mjtGeom.mjGEOM_CAPSULE:
            # Rerun's capsule starts at its own origin, MuJoCo's is centred.
            start = at - _rotation(model, geom).apply([0.0, 0.0, size[1]])
            return rr.Capsules3D(lengths=[2 * size[1]], radii=[size[0]], translations=[start], **look)
    return None


def _slab(model: mujoco.MjModel, geom: int, look: Mapping[str, Any]) -> rr.Boxes3D:
    size, extent = model.geom_size[geom], float(model.stat.extent)
    half = np.where(size[:2] > 0, size[:2], _SLAB_HALF_WIDTH * extent)
    thickness = _SLAB_THICKNESS * extent
    centre = model.geom_pos[geom] - _rotation(model, geom).apply([0.0, 0.0, thickness])
    return rr.Boxes3D(half_sizes=[[*half, thickness]], centers=[centre], **look)


def _mesh(model: mujoco.MjModel, geom: int, paint: Paint) -> rr.Mesh3D:
    """The mesh with the geom's pose baked in, because Mesh3D has none; shaded by face, because it has no normals."""
    mesh = int(model.geom_dataid[geom])
    vertices = _slice(model.mesh_vert, model.mesh_vertadr[mesh], model.mesh_vertnum[mesh])
    faces = _slice(model.mesh_face, model.mesh_faceadr[mesh], model.mesh_facenum[mesh])
    placed = _rotation(model, geom).apply(paint.swell * vertices) + model.geom_pos[geom]
    return rr.Mesh3D(vertex_positions=placed, triangle_indices=faces, albedo_factor=paint.colour)


def _slice(rows: Array, start: int, count: int) -> Array:
    return rows[start : start + count]


def _rotation(model: mujoco.MjModel, geom: int) -> Rotation:
    return Rotation.from_quat(model.geom_quat[geom], scalar_first=True)
