"""What sensors of the model, and of free bodies, read of the logs: positions, orientations, rates, accelerations."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.spatial.transform import Rotation

from dr_lab.physics.compiling import compiled
from dr_lab.proposal.by_name import matches, said_of
from dr_lab.proposal.gyros import TURNS
from dr_lab.proposal.output import Output
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import Survey
from dr_lab.proposal.vectors import Vector, VectorKind, find_vectors
from dr_lab.trajectory import Array

_SENSORS: Mapping[VectorKind, mujoco.mjtSensor] = {
    "position": mujoco.mjtSensor.mjSENS_FRAMEPOS,
    "orientation": mujoco.mjtSensor.mjSENS_FRAMEQUAT,
    "rate": mujoco.mjtSensor.mjSENS_GYRO,
    "acceleration": mujoco.mjtSensor.mjSENS_ACCELEROMETER,
}
_SI: Mapping[VectorKind, str] = {"position": "m", "orientation": "1", "rate": "rad/s", "acceleration": "m/s^2"}
_MJCF = {"rate": "gyro", "acceleration": "accelerometer"}
_AT_SITES = tuple(_MJCF)
_TINY = 1e-6  # m or rad, between frames that are one
NO_UNIT = "no unit is named; read as"  # what is unsure of numbers whose unit nothing tells


@dataclass
class Sensed:
    """What was found.

    Attributes:
        outputs: sensors and the series that they read.
        notes: what was added to the model, a sentence each.
        doubts: what is unsure, a sentence each.
    """

    outputs: list[Output] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    doubts: list[str] = field(default_factory=list)


def find_sensors(spec: mujoco.MjSpec, logs: Survey, settings: ProposalSettings) -> Sensed:
    """Find the series that sensors of the model read; free bodies get the sensors that the logs ask for.

    Args:
        spec: the robot's; sensors are added to it.
        logs: what the logs hold.
        settings: thresholds.
    """
    found, vectors = Sensed(), find_vectors([each for each in logs.series if each.moves])
    for kind in _SENSORS:
        mine = [vector for vector in vectors if vector.kind == kind]
        names = sensors_of(spec, kind) or (_added(spec, kind, found) if mine else [])
        found.doubts += [] if names else _unworn(spec, kind, mine)
        for name, vector in pairs(names, mine, found):
            unit, why, doubts = read_vector(vector, vectors, settings)
            doubts += _of_inertia(spec, name, kind)
            found.doubts += [f"sensor.{name}: {doubt}." for doubt in doubts]
            found.outputs.append(Output(f"sensor.{name}", vector.parts, unit, 1, 0.0, wrap=False, why=why))
    return found


def sensors_of(spec: mujoco.MjSpec, kind: VectorKind) -> list[str]:
    """Names of the model's sensors of a kind."""
    return [sensor.name for sensor in spec.sensors if sensor.type == _SENSORS[kind]]


def _of_inertia(spec: mujoco.MjSpec, name: str, kind: VectorKind) -> list[str]:
    """What is unsure of a sensor that reads the frame of a body's inertia, where that is not the body's own."""
    sensor = spec.sensor(name)
    if sensor.objtype != mujoco.mjtObj.mjOBJ_BODY:
        return []
    body = compiled(spec.copy()).body(sensor.objname)
    away, turned = float(np.linalg.norm(body.ipos)), Rotation.from_quat(body.iquat, scalar_first=True).magnitude()
    apart = {
        "position": f"the centre of mass, {away:.3g} m away from" if away > _TINY else "",
        "orientation": f"the axes of inertia, turned by {np.degrees(turned):.3g}° from" if turned > _TINY else "",
    }.get(kind)
    remedy = 'if the logs hold that frame itself, write objtype="xbody" in the model'
    return [f'objtype="body" reads {apart} the frame of body {sensor.objname}; {remedy}'] if apart else []


def _unworn(spec: mujoco.MjSpec, kind: VectorKind, vectors: Sequence[Vector]) -> Iterator[str]:
    """What is said of an inertial sensor's numbers where the model has none; no joint's rates are such."""
    joints = [joint.name for joint in spec.joints]
    for parts in (vector.parts for vector in vectors if kind in _AT_SITES and not said_of(joints, vector.parts)):
        listed, name = ", ".join(str(each.place) for each in parts), _MJCF[kind]
        yield (
            f"{listed} are a {name}'s by their names, and the model has none. To have them read, give the body that "
            f'carries it a <site name="imu"/>, and <sensor> a <{name} site="imu"/>.'
        )


def _added(spec: mujoco.MjSpec, kind: VectorKind, found: Sensed) -> list[str]:
    """Names of sensors that every free body gets."""
    names = []
    for body in spec.bodies[1:]:
        if not any(joint.type == mujoco.mjtJoint.mjJNT_FREE for joint in body.joints):
            continue
        name = f"{body.name}_{kind}"
        at, what = mujoco.mjtObj.mjOBJ_XBODY, body.name
        if kind in _AT_SITES:
            at, what = mujoco.mjtObj.mjOBJ_SITE, f"{body.name}_imu"
            if spec.site(what) is None:
                body.add_site(name=what)
        spec.add_sensor(name=name, type=_SENSORS[kind], objtype=at, objname=what)
        found.notes.append(f"Sensor {name} was added, at the origin of body {body.name}.")
        names.append(name)
    return names


def pairs(names: Sequence[str], vectors: Sequence[Vector], found: Sensed) -> list[tuple[str, Vector]]:
    """Sensors with the vectors that they read: the only ones of a kind, or by name."""
    if len(names) == len(vectors) == 1:
        return [(names[0], vectors[0])]
    places = matches(names, [vector.parts[0] for vector in vectors])
    pairs = [(name, vectors[each[0]]) for name, each in zip(names, places, strict=True) if len(each) == 1]
    open_ones = [name for name in names if name not in dict(pairs)]
    if names and vectors and open_ones:
        listed = ", ".join(str(vector.parts[0].place) for vector in vectors)
        found.doubts.append(f"{', '.join(open_ones)}: the names do not say which of {listed} … it is; left out.")
    return pairs


def read_vector(vector: Vector, vectors: Sequence[Vector], settings: ProposalSettings) -> tuple[str, str, list[str]]:
    """Unit of a vector's numbers, what speaks for the vector, and what is unsure about it."""
    said, usual = vector.unit, _SI[vector.kind]
    orientations = [each for each in vectors if each.kind == "orientation"]
    if vector.kind != "rate" or len(orientations) != 1:
        sure = said or vector.kind == "orientation"
        return said or usual, "by its name", [] if sure else [f"{NO_UNIT} {usual}"]
    gain, alike = _agreement(*_turns(vector, orientations[0], settings.half_width))
    if alike < settings.turns:
        doubt = f"it turns another way than the orientation (correlation {alike:.2g}): another frame, order or body?"
        return said or usual, "by its name", [doubt]
    seen = min(TURNS, key=lambda name: abs(np.log(gain / TURNS[name])))
    doubts = [f"the orientation turns as {seen} would, not as {said}"] if said not in ("", seen) else []
    if _agreement(*_turns(vector, orientations[0], 0.0))[1] > settings.derived:
        doubts.append("it follows the orientation from sample to sample; if it was computed from that, delete it")
    return seen, f"turns as the orientation does (correlation {alike:.2g})", doubts


def _turns(rate: Vector, orientation: Vector, span: float) -> tuple[Array, Array]:
    """How an orientation turns in the body's frame, and what the rates add up to, over spans of so many seconds.

    Over long ones a sensor's noise is small; a span of 0 is from sample to sample. Shape (n, 3) both.
    """
    turned, added = list[Array](), list[Array]()
    for k in range(len(rate.parts[0].signals)):
        time, quaternion = orientation.log(k)
        found = quaternion.any(axis=1)  # a tracker that lost its body reports zeros
        time, quaternion = time[found], quaternion[found]
        apart = max(round(span / float(np.median(np.diff(time)))), 1)
        turns = Rotation.from_quat(quaternion, scalar_first=True)
        turned.append((turns[:-apart].inv() * turns[apart:]).as_rotvec())
        at, measured = rate.log(k)
        angles = cumulative_trapezoid(measured, at, axis=0, initial=0.0)
        reached = np.stack([np.interp(time, at, column) for column in angles.T], axis=-1)
        added.append(reached[apart:] - reached[:-apart])
    return np.concatenate(turned), np.concatenate(added)


def _agreement(turned: Array, added: Array) -> tuple[float, float]:
    """Gain of the first over the second, and their correlation."""
    product, own = float((turned * added).sum()), float((added**2).sum())
    return product / own, product / float(np.sqrt(own * (turned**2).sum()))
