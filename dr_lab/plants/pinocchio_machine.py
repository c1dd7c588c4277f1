"""Machines whose mass matrix and forces Pinocchio works out, at one instant at a time."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.errors import ModelError
from dr_lab.plants.machine import Matrix, Vector
from dr_lab.plants.medium import box_drag, half_lengths
from dr_lab.plants.mjcf_nominal import MjcfNominal
from dr_lab.plants.mujoco_machine import MujocoMachine
from dr_lab.plants.pinocchio_engine import pinocchio, tree
from dr_lab.trajectory import Array

_AFFINE = int(mujoco.mjtBias.mjBIAS_AFFINE)
_PLAIN = (int(mujoco.mjtBias.mjBIAS_NONE), _AFFINE)


@dataclass(frozen=True, eq=False)
class PinocchioMachine(MujocoMachine):
    """M(q) q'' = f of a tree of hinges and slides; only the numbers come from the MuJoCo model, no equation.

    f = applied + drives − damping q' − C(q, q') q' − g(q) + drag of the medium + gears, where a drive is
    gear (gain u + b₀ + b₁ l + b₂ l'), l = gear q: a motor's or a position controller's of MuJoCo's file. There are no
    contacts, limits, springs or frictions but those that are hidden.
    """

    def terms(self, position: Vector, velocity: Vector, command: Vector, applied: Vector) -> tuple[Matrix, Vector]:
        """Mass matrix and force."""
        engine, (model, data) = pinocchio(), self._tree
        q, v = np.asarray(position, dtype=np.float64), np.asarray(velocity, dtype=np.float64)
        mass = engine.crba(model, data, q)
        outside = -engine.nonLinearEffects(model, data, q, v)
        drive = self._drive(q, v, np.asarray(command, dtype=np.float64))
        force = np.asarray(self._coupled(position, applied)) + drive + outside - self.model.dof_damping * v
        for joint, law in self.gears:
            force[joint] += law(float(drive[joint]), float(outside[joint]), velocity[joint])
        if self.model.opt.density > 0:
            force = force + self._drag(q[None], v[None])[0]
        return np.reshape(mass, (len(q), len(q))).tolist(), force.tolist()

    def lacking(self, position: Array, velocity: Array, acceleration: Array, command: Array) -> Array:
        """M q'' − f; without gears, whose law asks for f itself, by the recursive Newton–Euler algorithm at once."""
        if self.gears:
            return super().lacking(position, velocity, acceleration, command)
        engine, (model, data) = pinocchio(), self._tree
        asked = np.empty(np.shape(position))  # filled in place: stacking thousands of rows takes longer than their sums
        for row, *state in zip(asked, position, velocity, acceleration, strict=True):
            row[:] = engine.rnea(model, data, *state)
        asked += self.model.dof_damping * velocity - self._drive(position, velocity, command)
        if self.couplings or self.cables:
            asked -= [self._coupled(q.tolist(), [0.0] * len(q)) for q in position]
        if self.model.opt.density > 0:
            asked -= self._drag(position, velocity)
        return asked

    def _drive(self, q: Array, v: Array, command: Array) -> Array:
        """Forces of the drives at each joint, shape (…, n), as positions and velocities are."""
        joint, gear, gain, bias = self._drives
        pulled = bias[:, 1] * q[..., joint] + bias[:, 2] * v[..., joint]
        return np.asarray((gear * (gain * command + bias[:, 0] + gear * pulled)) @ self._driven, dtype=np.float64)

    def _drag(self, position: Array, velocity: Array) -> Array:
        """Generalised forces of the medium, shape (k, n), as positions and velocities are."""
        turned, jacobian = self._boxes_moved(position)
        past = np.einsum("kbpn,kn->kbp", jacobian, velocity)
        past[..., :3] -= self.model.opt.wind @ turned
        half = np.stack([box[-1] for box in self._boxes])
        pushed = np.concatenate(box_drag(self.model.opt.density, half, past[..., :3], past[..., 3:]), axis=-1)
        return np.einsum("kbpn,kbp->kn", jacobian, pushed)

    def _boxes_moved(self, position: Array) -> tuple[Array, Array]:
        """Axes of each box in the world, (k, b, 3, 3), and its Jacobian there, of centre and turn, (k, b, 6, n)."""
        engine, (model, data) = pinocchio(), self._tree
        count, joints = np.shape(position)
        turned, jacobian = np.empty((count, len(self._boxes), 3, 3)), np.empty((count, len(self._boxes), 6, joints))
        for k, q in enumerate(position):
            engine.computeJointJacobians(model, data, q)
            for box, (number, *_) in enumerate(self._boxes):
                turned[k, box] = data.oMi[number].rotation
                # One column comes back as a vector.
                own = engine.getJointJacobian(model, data, number, engine.ReferenceFrame.LOCAL)
                jacobian[k, box] = np.reshape(own, (6, joints))
        return turned @ np.stack([axes for _, _, axes, _ in self._boxes]), self._carried @ jacobian

    @cached_property
    def _carried(self) -> Array:
        """From a joint's velocity and spin along its axes to those of its box's centre along the box's, (b, 6, 6)."""
        found = np.zeros((len(self._boxes), 6, 6))
        for carried, (_, (x, y, z), axes, _) in zip(found, self._boxes, strict=True):
            carried[:3, :3] = carried[3:, 3:] = axes.T
            carried[:3, 3:] = axes.T @ [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]  # spin × centre
        return found

    def centre(self, position: Array, body: str) -> tuple[Array, Array]:
        """A body's centre of mass in the world, m, shape (3,), and its Jacobian, shape (3, n)."""
        engine, (model, data) = pinocchio(), self._tree
        engine.computeJointJacobians(model, data, position)
        number, reach, *_ = next(
            box for box in self._boxes[::-1] if self.model.jnt_bodyid[box[0] - 1] == self._row(body)
        )
        frame, world = data.oMi[number], engine.ReferenceFrame.LOCAL_WORLD_ALIGNED
        jacobian = np.reshape(engine.getJointJacobian(model, data, number, world), (6, len(position)))
        x, y, z = way = frame.rotation @ reach
        turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])  # of a turn about each axis, as columns
        return frame.translation + way, jacobian[:3] + turned @ jacobian[3:]

    @cached_property
    def _tree(self) -> tuple[Any, Any]:
        model = tree(self.model)
        return model, model.createData()

    @cached_property
    def _drives(self) -> tuple[NDArray[np.intp], Array, Array, Array]:
        """Joint, gear, gain and bias of each actuator."""
        model = self.model
        at_joints = (model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT)).all()
        plain = np.isin(model.actuator_biastype, _PLAIN).all() and not model.actuator_dyntype.any()
        if not at_joints or not plain or model.actuator_gaintype.any():
            raise ModelError("A machine of Pinocchio is driven at its joints, by motors or position controllers alone.")
        bias = model.actuator_biasprm[:, :3] * (model.actuator_biastype == _AFFINE)[:, None]
        return model.actuator_trnid[:, 0].astype(np.intp), model.actuator_gear[:, 0], model.actuator_gainprm[:, 0], bias

    @cached_property
    def _driven(self) -> Array:
        """1 where an actuator drives a joint, shape (actuators, n)."""
        return np.eye(len(self.joints))[self._drives[0]]

    @cached_property
    def _boxes(self) -> list[tuple[int, Array, Array, Array]]:
        """Of each body that a joint moves: the joint's number, its box's centre and axes in its frame, half-lengths."""
        model, found = self.model, []
        for joint, row in enumerate(model.jnt_bodyid.tolist()):
            axes = np.zeros(9)
            mujoco.mju_quat2Mat(axes, model.body_iquat[row])
            half = half_lengths(float(model.body_mass[row]), model.body_inertia[row])
            found.append((joint + 1, model.body_ipos[row] - model.jnt_pos[joint], axes.reshape(3, 3), half))
        return found


@dataclass(frozen=True, kw_only=True)
class PinocchioNominal(MjcfNominal):
    """A machine whose documents are an MJCF file, played by Pinocchio."""

    def machine(self, true: Mapping[str, float]) -> PinocchioMachine:
        """The machine with given masses and dampings."""
        return PinocchioMachine.of(self.model(true))
