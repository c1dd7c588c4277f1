"""A floor that is not level."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.contact_pairs import meeting
from dr_lab.effects.effect import Effect, Scales
from dr_lab.errors import ModelError
from dr_lab.physics.compiling import compiled
from dr_lab.physics.effect_parts import SpecEdit, SpecPreparation
from dr_lab.physics.parameter import Parameter

_AXES = ("about_x", "about_y")
_STILL = 1e-9  # m/s for a unit velocity of a joint; rounding


@dataclass(frozen=True)
class FloorSlope(Effect, SpecPreparation, SpecEdit):
    """A plane that is turned about the world's x and y through its own origin, while gravity stays.

    n' = exp([r]×) n with r = (r_x, r_y, 0), n the plane's normal.

    Parameters (nominal = absent): about_x, about_y [rad]; each only if a body that touches the plane can move in the
    direction in which the angle tips the normal (a planar machine in x and z does not feel a turn about x).
    Limits: planes fixed to the world that something can touch; where the robot's frame tilts along, it is a base tilt.
    Raises: ModelError for a plane in a <frame>, whose orientation in the file is not that in the world.
    Source: Rodrigues' rotation formula; MuJoCo geom/plane.

    Attributes:
        largest: bound of either angle [rad].
    """

    largest: float

    name: ClassVar[str] = "floor_slope"
    family: ClassVar[str] = "environment"
    law: ClassVar[str] = "n -> R(about_x, about_y) n"
    fingerprint: ClassVar[str] = "contacts push sideways by the same share everywhere; what rests on the floor creeps"
    confused_with: ClassVar[tuple[str, ...]] = ("base_tilt", "contact_friction")

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the planes of the world that something can touch."""
        touched = {geom for body in range(1, model.nbody) for pair in meeting(model, body) for geom in pair}
        planes = np.flatnonzero((model.geom_type == int(mujoco.mjtGeom.mjGEOM_PLANE)) & (model.geom_bodyid == 0))
        names = (model.geom(int(p)).name for p in planes if int(p) in touched)
        return tuple(name for name in names if name and _felt(model, name))

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The two angles."""
        del scales
        return tuple(Parameter(axis, "rad", 0.0, -self.largest, self.largest) for axis in _felt(model, site))

    def prepare(self, spec: mujoco.MjSpec, site: str) -> None:
        """Write the plane's orientation as a quat, in whichever form it stands."""
        plane = spec.geom(site)
        if plane.frame is not None:
            raise ModelError(
                f"Plane {site!r} stands in a <frame>, whose axes are not the world's. Write the plane with a pos and "
                "an orientation of its own."
            )
        if plane.alt.type != mujoco.mjtOrientation.mjORIENTATION_QUAT:
            plane.quat = compiled(spec.copy()).geom(site).quat
            plane.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Turn the plane."""
        vector = np.array([*(values.get(axis, 0.0) for axis in _AXES), 0.0])
        angle = float(np.linalg.norm(vector))
        if angle == 0:
            return
        plane, turn, turned = spec.geom(site), np.zeros(4), np.zeros(4)
        mujoco.mju_axisAngle2Quat(turn, vector / angle, angle)
        mujoco.mju_mulQuat(turned, turn, np.array(plane.quat))
        plane.quat = turned


def _felt(model: mujoco.MjModel, plane: str) -> tuple[str, ...]:
    """Axes whose turn tips the plane's normal in a direction in which a body that touches it can move."""
    data, place = mujoco.MjData(model), model.geom(plane).id
    mujoco.mj_integratePos(model, data.qpos, np.sin(np.arange(1.0, model.nv + 1.0)), 1.0)  # no special pose
    mujoco.mj_fwdPosition(model, data)
    normal, moves = data.geom_xmat[place].reshape(3, 3)[:, 2], [np.zeros((3, model.nv))]
    for body in range(1, model.nbody):
        if any(place in pair for pair in meeting(model, body)):
            moves.append(np.zeros((3, model.nv)))
            mujoco.mj_jacBody(model, data, moves[-1], None, body)
    tips = {axis: np.cross(direction, normal) for axis, direction in zip(_AXES, np.eye(3), strict=False)}
    return tuple(axis for axis, tip in tips.items() if any(np.abs(tip @ move).max() > _STILL for move in moves))
