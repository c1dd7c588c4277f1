"""Machines whose mass matrix and forces MuJoCo works out, at one instant at a time."""

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import mujoco
import numpy as np

from dr_lab.plants.cable import Cable
from dr_lab.plants.inertia import moved, with_point
from dr_lab.plants.machine import Gravity, Matrix, Vector, index
from dr_lab.plants.mjcf_nominal import MjcfNominal
from dr_lab.trajectory import Array

# What a gear adds at its joint, N·m or N, from the drive's force there, that of gravity and of the motion itself, and
# the joint's velocity.
GearLaw = Callable[[float, float, float], float]


@dataclass(frozen=True)
class Coupling:
    """A cable over two pulleys: its stretch is first radius · q − second radius · q − slack, its pull is in proportion.

    Attributes:
        joints: places of two joints.
        radii: way of the cable for a unit of each joint's position.
        slack: of the cable, in the same unit.
        stiffness: pull for each unit of stretch.
    """

    joints: tuple[int, int]
    radii: tuple[float, float]
    slack: float
    stiffness: float

    def added(self, position: Vector, applied: Vector) -> list[float]:
        """Applied forces and those of the cable."""
        (one, two), (first, second) = self.joints, self.radii
        pull = self.stiffness * (first * position[one] - second * position[two] - self.slack)
        total = list(applied)
        total[one] -= first * pull
        total[two] += second * pull
        return total


@dataclass(frozen=True, eq=False)
class MujocoMachine:
    """M(q) and f(q, q', u) of a MuJoCo model, contact forces included; nothing of its stepping through time is used.

    Contact forces depend on the acceleration that all other forces cause, so that M q'' = f holds for the acceleration
    without any further force.

    Attributes:
        model: compiled model of hinges and slides.
        joints: names of the joints, in the order of q.
        bodies: names of the bodies that the joints move.
        actuators: names of the actuators.
        gears: joint and law of what gears add.
        couplings: cables between joints.
        cables: those between the world and a body.
    """

    model: mujoco.MjModel
    joints: tuple[str, ...]
    bodies: tuple[str, ...]
    actuators: tuple[str, ...]
    gears: tuple[tuple[int, GearLaw], ...] = ()
    couplings: tuple[Coupling, ...] = ()
    cables: tuple[Cable, ...] = ()

    @classmethod
    def of(cls, model: mujoco.MjModel) -> Self:
        """The machine of a model, its derived constants made anew."""
        mujoco.mj_setConst(model, mujoco.MjData(model))
        return cls(
            model,
            tuple(model.joint(i).name for i in range(model.njnt)),
            tuple(dict.fromkeys(model.body(int(body)).name for body in model.jnt_bodyid)),
            tuple(model.actuator(i).name for i in range(model.nu)),
        )

    @property
    def gravity(self) -> Gravity:
        """Acceleration of gravity, m/s²."""
        x, y, z = self.model.opt.gravity.tolist()
        return x, y, z

    def terms(self, position: Vector, velocity: Vector, command: Vector, applied: Vector) -> tuple[Matrix, Vector]:
        """Mass matrix and force."""
        data, dense = self._data
        applied = self._coupled(position, applied)
        data.qpos[:], data.qvel[:] = position, velocity
        data.ctrl[:], data.qfrc_applied[:] = command, applied
        mujoco.mj_forward(self.model, data)
        for joint, law in self.gears:
            drive, outside = float(data.qfrc_actuator[joint]), -float(data.qfrc_bias[joint])
            data.qfrc_applied[joint] += law(drive, outside, velocity[joint])
        if self.gears:
            mujoco.mj_forward(self.model, data)
        mujoco.mj_fullM(self.model, data, dense)
        return dense.tolist(), (data.qfrc_smooth + data.qfrc_constraint).tolist()

    def lacking(self, position: Array, velocity: Array, acceleration: Array, command: Array) -> Array:
        """M q'' − f, the forces that it lacks to move like that, N·m or N, shape (K, n).

        Args:
            position: rad or m, shape (K, n).
            velocity: the same.
            acceleration: the same.
            command: shape (K, actuators).
        """
        none, rows = [0.0] * len(self.joints), []
        for q, v, a, u in zip(position, velocity, acceleration, command, strict=True):
            mass, force = self.terms(q.tolist(), v.tolist(), u.tolist(), none)
            rows.append(np.asarray(mass) @ a - force)
        return np.asarray(rows)

    def with_armature(self, joint: str, inertia: float) -> Self:
        """With rotor inertia at a joint."""
        model = copy.copy(self.model)
        model.dof_armature[index("joint", joint, self.joints)] += inertia
        return self._altered(model)

    def with_load(self, body: str, mass: float, distance: float) -> Self:
        """With a point mass on the line from a body's last joint to its centre of mass, across the joint's axis."""
        anchor, lever = self._arm(body)
        length = float(np.linalg.norm(lever))
        return self.with_mass_at(body, mass, anchor + (distance / length * lever if length else 0.0))

    def lever(self, body: str) -> float:
        """Distance of a body's centre of mass from its joint's axis, m."""
        return float(np.linalg.norm(self._arm(body)[1]))

    def turns(self, body: str) -> bool:
        """Whether a hinge between the world and a body turns it."""
        row, hinge = self._row(body), int(mujoco.mjtJoint.mjJNT_HINGE)
        while row:
            if any(int(self.model.jnt_type[joint]) == hinge for joint in self._joints(row)):
                return True
            row = int(self.model.body_parentid[row])
        return False

    def in_plane(self, body: str, places: Array) -> Array:
        """Places in the plane across a body's last hinge (m, shape (k, 2)), in its frame; none without a hinge."""
        joint = self._joints(self._row(body))[-1]
        if int(self.model.jnt_type[joint]) != int(mujoco.mjtJoint.mjJNT_HINGE):
            return np.zeros((0, 3))
        plane = np.linalg.svd(self.model.jnt_axis[joint][None])[2][1:]
        return np.asarray(self.model.jnt_pos[joint] + places @ plane, dtype=np.float64)

    def with_mass_at(self, body: str, mass: float, place: Array) -> Self:
        """With a point mass (kg) at a place in a body's frame (m, shape (3,)), put together by the parallel axes."""
        model = copy.copy(self.model)
        with_point(model, self._row(body), mass, place)
        return self._altered(model)

    def with_centre_moved(self, body: str, offset: Array) -> Self:
        """With a body's centre of mass moved in the body's frame (m, shape (3,)); its mass and own inertia stay."""
        model = copy.copy(self.model)
        moved(model, self._row(body), offset)
        return self._altered(model)

    def with_inertia_scaled(self, body: str, factor: float) -> Self:
        """With a body's inertia about its own centre scaled; mass and centre stay."""
        model = copy.copy(self.model)
        model.body_inertia[self._row(body)] *= factor
        return self._altered(model)

    def with_medium(self, density: float, wind: tuple[float, float, float]) -> Self:
        """In a medium that is denser (kg/m³) and moves faster (m/s) than the documented one."""
        model = copy.copy(self.model)
        model.opt.density += density
        model.opt.wind += wind
        return self._altered(model)

    def with_gear_law(self, joint: str, law: GearLaw) -> Self:
        """With a gear that adds a force of its own at a joint."""
        return replace(self, gears=(*self.gears, (index("joint", joint, self.joints), law)))

    def with_coupling(self, coupling: Coupling) -> Self:
        """With a cable between two joints."""
        return replace(self, couplings=(*self.couplings, coupling))

    def with_cable(self, cable: Cable) -> Self:
        """With a cable between the world and a body."""
        self._row(cable.body)
        return replace(self, cables=(*self.cables, cable))

    def with_link_longer(self, body: str, by: float) -> Self:
        """With a body, and all that hangs on it, farther by so many m from the axis of its parent's last hinge."""
        model, row, way = copy.copy(self.model), self._row(body), self._way(body)
        model.body_pos[row] += by * way / np.linalg.norm(way)
        return self._altered(model)

    def link(self, body: str) -> float:
        """Distance of a body from the axis of its parent's last hinge, m; 0 without one."""
        return float(np.linalg.norm(self._way(body)))

    def with_stiffness_scaled(self, actuator: str, share: float) -> Self:
        """With a position controller of whose documented gain only a share acts; its damping gain stays."""
        model, row = copy.copy(self.model), index("actuator", actuator, self.actuators)
        model.actuator_gainprm[row, 0] *= share
        model.actuator_biasprm[row, 1] *= share
        return self._altered(model)

    def with_floor_turned(self, floor: str, turn: Array) -> Self:
        """With a plane turned by a quaternion (wxyz) about its own origin."""
        model, turned = copy.copy(self.model), np.zeros(4)
        plane = model.geom(floor)
        mujoco.mju_mulQuat(turned, turn, plane.quat)
        plane.quat[:] = turned
        model.geom_sameframe[plane.id] = int(mujoco.mjtSameFrame.mjSAMEFRAME_NONE)
        return self._altered(model)

    def with_gravity(self, gravity: Gravity) -> Self:
        """In another gravity."""
        model = copy.copy(self.model)
        model.opt.gravity = gravity
        return self._altered(model)

    def with_drive_scaled(self, actuator: str, share: float) -> Self:
        """With a share of an actuator's whole force, be it a motor's or a position controller's, its limit included."""
        model, row = copy.copy(self.model), index("actuator", actuator, self.actuators)
        for numbers in (model.actuator_gainprm, model.actuator_biasprm, model.actuator_forcerange):
            numbers[row] *= share
        return self._altered(model)

    def with_contact(self, friction: float, time_constant: float, damping_ratio: float) -> Self:
        """With contacts whose sliding friction, time constant and damping ratio are shares of the documented ones."""
        model = copy.copy(self.model)
        model.geom_friction[:, 0] *= friction
        model.geom_solref[:] *= [time_constant, damping_ratio]
        return self._altered(model)

    def _altered(self, model: mujoco.MjModel) -> Self:
        return replace(type(self).of(model), gears=self.gears, couplings=self.couplings, cables=self.cables)

    def _coupled(self, position: Vector, applied: Vector) -> Vector:
        for coupling in self.couplings:
            applied = coupling.added(position, applied)
        for cable in self.cables:
            place, turning = self.centre(np.asarray(position, np.float64), cable.body)
            applied = (applied + cable.pull(place) @ turning).tolist()
        return applied

    def centre(self, position: Array, body: str) -> tuple[Array, Array]:
        """A body's centre of mass in the world, m, shape (3,), and its Jacobian, shape (3, n)."""
        data, row = mujoco.MjData(self.model), self._row(body)
        data.qpos[:] = position
        mujoco.mj_kinematics(self.model, data)
        mujoco.mj_comPos(self.model, data)
        turning = np.zeros((3, self.model.nv))
        mujoco.mj_jacBodyCom(self.model, data, turning, None, row)
        return data.xipos[row].copy(), turning

    def _arm(self, body: str) -> tuple[Array, Array]:
        """Where a body's last joint is, and the way from there to its centre across its axis, m, shape (3,).

        Of several joints only the last one rests in the body's frame; the others' axes turn with the ones behind them.
        """
        row = self._row(body)
        joint = self._joints(row)[-1]
        axis, anchor = self.model.jnt_axis[joint], self.model.jnt_pos[joint]
        reach = self.model.body_ipos[row] - anchor
        return anchor, reach - axis * (axis @ reach)

    def _way(self, body: str) -> Array:
        """From the axis of the last hinge of a body's parent to the body, across the axis, m; 0 without a hinge."""
        row, turns = self._row(body), int(mujoco.mjtJoint.mjJNT_HINGE)
        hinges = [j for j in self._joints(int(self.model.body_parentid[row])) if int(self.model.jnt_type[j]) == turns]
        if not hinges:
            return np.zeros(3)
        axis, way = self.model.jnt_axis[hinges[-1]], self.model.body_pos[row] - self.model.jnt_pos[hinges[-1]]
        return np.asarray(way - axis * (axis @ way), dtype=float)

    def _joints(self, row: int) -> range:
        first = int(self.model.body_jntadr[row])
        return range(first, first + int(self.model.body_jntnum[row]))

    def _row(self, body: str) -> int:
        index("body", body, self.bodies)
        return int(self.model.body(body).id)

    @cached_property
    def _data(self) -> tuple[mujoco.MjData, Array]:
        return mujoco.MjData(self.model), np.zeros((self.model.nv, self.model.nv))


@dataclass(frozen=True, kw_only=True)
class MujocoNominal(MjcfNominal):
    """A machine whose documents are an MJCF file, played by MuJoCo."""

    def machine(self, true: Mapping[str, float]) -> MujocoMachine:
        """The machine with given masses and dampings."""
        return MujocoMachine.of(self.model(true))
