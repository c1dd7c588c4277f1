"""Where a free body begins a window, from sensors of frames that are fixed to it."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.channels import Channel, available
from dr_lab.diagnosis.windows.local_fits import reaches, vectors
from dr_lab.diagnosis.windows.orientations import of_the_body, turn_between, turning
from dr_lab.diagnosis.windows.start_prior import StartPrior
from dr_lab.trajectory import Array, Log, Noise

_SENSORS = (int(mujoco.mjtSensor.mjSENS_FRAMEPOS), int(mujoco.mjtSensor.mjSENS_FRAMEQUAT))
_FRAME, _INERTIAL, _SITE = (
    int(kind) for kind in (mujoco.mjtObj.mjOBJ_XBODY, mujoco.mjtObj.mjOBJ_BODY, mujoco.mjtObj.mjOBJ_SITE)
)


@dataclass(frozen=True)
class Mounted:
    """A channel of a frame that is fixed to a body.

    Attributes:
        channel: position or orientation of the frame in the world.
        place: of the frame in the body, m, shape (3,).
        turn: of the frame in the body, unit quaternion wxyz, shape (4,).
    """

    channel: Channel
    place: Array
    turn: Array


@dataclass(frozen=True)
class FreeBody:
    """A body on a free joint of the world.

    Attributes:
        body: its number.
        address: first of its seven entries in qpos.
        dof: first of its six degrees of freedom.
        position: what tells its place in the world, if anything does.
        orientation: what tells its orientation in the world, if anything does.
    """

    body: int
    address: int
    dof: int
    position: Mounted | None
    orientation: Mounted | None


def free_bodies(model: mujoco.MjModel, measured: Collection[str]) -> tuple[FreeBody, ...]:
    """Free bodies, with measured ``framepos`` and ``framequat`` in the world of frames that are fixed to them.

    Such a frame is that of the body (``xbody``), of its inertia (``body``), or a site, there or on what is welded to
    it. A place away from the body's own frame needs the orientation.

    Args:
        model: compiled model.
        measured: names of the measured channels.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    found = []
    for i in np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE):
        body = int(model.jnt_bodyid[i])
        seen = dict(_mounted(model, data, body, measured))
        position, orientation = (seen.get(sensor) for sensor in _SENSORS)
        if position and position.place.any() and not orientation:
            position = None
        found.append(FreeBody(body, int(model.jnt_qposadr[i]), int(model.jnt_dofadr[i]), position, orientation))
    return tuple(found)


def _mounted(
    model: mujoco.MjModel, data: mujoco.MjData, body: int, measured: Collection[str]
) -> Iterator[tuple[int, Mounted]]:
    """Type of sensor and mount of each measured frame; of several the one that the model names last counts."""
    channels = available(model)
    frame = Rotation.from_matrix(data.xmat[body].reshape(3, 3))
    for i in range(model.nsensor):
        name, kind, number = f"sensor.{model.sensor(i).name}", int(model.sensor_objtype[i]), int(model.sensor_objid[i])
        if int(model.sensor_type[i]) not in _SENSORS or model.sensor_refid[i] >= 0 or name not in measured:
            continue
        if kind == _SITE:
            owner, place, turn = int(model.site_bodyid[number]), data.site_xpos[number], data.site_xmat[number]
        elif kind in {_FRAME, _INERTIAL}:
            inertial = kind == _INERTIAL
            place, turn = (data.xipos, data.ximat) if inertial else (data.xpos, data.xmat)
            owner, place, turn = number, place[number], turn[number]
        else:
            continue
        if model.body_weldid[owner] == body:
            mount = frame.inv() * Rotation.from_matrix(turn.reshape(3, 3))
            yield (
                int(model.sensor_type[i]),
                Mounted(
                    channels[name],
                    np.round(frame.inv().apply(place - data.xpos[body]), 12),
                    mount.as_quat(scalar_first=True),
                ),
            )


def place_by_sensors(
    prior: StartPrior,
    body: FreeBody,
    logs: Sequence[Log],
    begins: Sequence[Array],
    noise: Mapping[str, Noise],
    settings: WindowSettings,
) -> None:
    """Write a free body's orientation, place and velocities into the prior, as far as sensors show them."""
    wide_and_narrow = reaches(settings)
    if body.orientation:
        mount, turn = body.orientation, body.orientation.turn
        wide, narrow = (
            turning(*(of_the_body(part, turn) for part in vectors(logs, mount.channel, begins, reach, settings)))
            for reach in wide_and_narrow
        )
        error = 2.0 * noise[mount.channel.name].std  # a turn by φ moves a unit quaternion by φ/2
        missed = turn_between(narrow[0], wide[0]), wide[1] - narrow[1]
        _write(prior, (body.address + 3, body.dof + 3), wide, missed, error, settings)
    if body.position:
        mount = body.position
        wide, narrow = (vectors(logs, mount.channel, begins, reach, settings) for reach in wide_and_narrow)
        missed, error = (wide[0] - narrow[0], wide[1] - narrow[1]), noise[mount.channel.name].std
        arm = _arm(prior, body, mount.place)
        wide = tuple(part - away for part, away in zip(wide, arm, strict=True))
        _write(prior, (body.address, body.dof), wide, missed, error, settings)


def _arm(prior: StartPrior, body: FreeBody, place: Array) -> tuple[Array, Array, Array]:
    """Place, velocity and acceleration of a point of the body from its frame's origin, in the world, (w, 3) each."""
    turn = Rotation.from_quat(prior.qpos[:, body.address + 3 : body.address + 7], scalar_first=True)
    spins = slice(body.dof + 3, body.dof + 6)
    spin, spun_up = prior.qvel[:, spins], prior.qacc[:, spins]
    velocity = np.cross(spin, place)
    acceleration = np.cross(spun_up, place) + np.cross(spin, velocity)
    return tuple(turn.apply(part) for part in (np.tile(place, (len(spin), 1)), velocity, acceleration))


def _write(
    prior: StartPrior,
    where: tuple[int, int],
    found: tuple[Array, ...],
    missed: tuple[Array, Array],
    error: float,
    settings: WindowSettings,
) -> None:
    """Value, slope and curvature from an entry of qpos and a degree of freedom on, and their standard deviations."""
    address, nv = where[0], prior.qvel.shape[1]
    dofs = where[1] + np.arange(3)
    prior.qpos[:, address : address + found[0].shape[1]] = found[0]
    prior.qvel[:, dofs], prior.qacc[:, dofs] = found[1:]
    for first, wrong, floor in ((0, missed[0], error), (nv, missed[1], error / settings.smoother)):
        prior.std[first + dofs] = settings.prior_scale * np.maximum(floor, np.sqrt((wrong**2).mean(0)))
