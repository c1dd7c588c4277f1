"""Machines whose mass matrix and forces MuJoCo works out, at one instant at a time."""

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np

from dr_lab.errors import ModelError
from dr_lab.plants.machine import Gravity, Matrix, Vector, index
from dr_lab.plants.nominal import Nominal
from dr_lab.trajectory import Array

# Contact forces to rounding, so that the integrator's error estimate sees no noise of the solver.
_PRECISE = {"tolerance": 1e-14, "ls_tolerance": 1e-4, "iterations": 200, "ls_iterations": 200}


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
    """

    model: mujoco.MjModel
    joints: tuple[str, ...]
    bodies: tuple[str, ...]
    actuators: tuple[str, ...]

    @classmethod
    def of(cls, model: mujoco.MjModel) -> "MujocoMachine":
        """The machine of a model, its derived constants made anew."""
        mujoco.mj_setConst(model, mujoco.MjData(model))
        return cls(
            model,
            tuple(model.joint(i).name for i in range(model.njnt)),
            tuple(model.body(int(body)).name for body in model.jnt_bodyid),
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
        data.qpos[:], data.qvel[:] = position, velocity
        data.ctrl[:], data.qfrc_applied[:] = command, applied
        mujoco.mj_forward(self.model, data)
        mujoco.mj_fullM(self.model, data, dense)
        return dense.tolist(), (data.qfrc_smooth + data.qfrc_constraint).tolist()

    def with_armature(self, joint: str, inertia: float) -> "MujocoMachine":
        """With rotor inertia at a joint."""
        model = copy.copy(self.model)
        model.dof_armature[index("joint", joint, self.joints)] += inertia
        return MujocoMachine.of(model)

    def with_load(self, body: str, mass: float, distance: float) -> "MujocoMachine":
        """With a point mass on the line from a body's joint to its centre of mass, across the joint's axis.

        Centre and inertia are put together by the parallel-axis theorem.
        """
        model = copy.copy(self.model)
        joint = index("body", body, self.bodies)
        row, axis, anchor = int(model.jnt_bodyid[joint]), model.jnt_axis[joint], model.jnt_pos[joint]
        turn, own, centre = np.zeros(9), float(model.body_mass[row]), model.body_ipos[row].copy()
        lever = centre - anchor - axis * (axis @ (centre - anchor))
        length = float(np.linalg.norm(lever))
        place = anchor + (distance / length * lever if length else 0.0)
        mujoco.mju_quat2Mat(turn, model.body_iquat[row])
        frame = turn.reshape(3, 3)
        tensor = frame @ np.diag(model.body_inertia[row]) @ frame.T
        common = (own * centre + mass * place) / (own + mass)
        tensor += own * _about(centre - common) + mass * _about(place - common)
        model.body_mass[row], model.body_ipos[row] = own + mass, common
        model.body_inertia[row], model.body_iquat[row] = _principal(tensor)
        model.body_sameframe[row] = int(mujoco.mjtSameFrame.mjSAMEFRAME_NONE)  # its axes are no longer the body's
        return MujocoMachine.of(model)

    def with_gravity(self, gravity: Gravity) -> "MujocoMachine":
        """In another gravity."""
        model = copy.copy(self.model)
        model.opt.gravity = gravity
        return MujocoMachine.of(model)

    def with_drive_scaled(self, actuator: str, share: float) -> "MujocoMachine":
        """With a weaker (or stronger) drive."""
        model = copy.copy(self.model)
        model.actuator_gear[index("actuator", actuator, self.actuators)] *= share
        return MujocoMachine.of(model)

    def with_contact(self, friction: float, time_constant: float, damping_ratio: float) -> "MujocoMachine":
        """With contacts whose sliding friction, time constant and damping ratio are shares of the documented ones."""
        model = copy.copy(self.model)
        model.geom_friction[:, 0] *= friction
        model.geom_solref[:] *= [time_constant, damping_ratio]
        return MujocoMachine.of(model)

    @cached_property
    def _data(self) -> tuple[mujoco.MjData, Array]:
        return mujoco.MjData(self.model), np.zeros((self.model.nv, self.model.nv))


@dataclass(frozen=True, kw_only=True)
class MujocoNominal(Nominal):
    """A machine whose documents are an MJCF file.

    Attributes:
        mjcf: the file.
        free: what is not exactly known: ``<body>.mass``, whose inertia scales with it, or ``<joint>.damping``.

    Raises:
        ModelError: the model is not one of hinges and slides with one command to each actuator.
    """

    mjcf: str
    free: Sequence[str]

    def documented(self) -> dict[str, float]:
        """Masses (kg) and dampings (N·m·s/rad or N·s/m) as the file has them."""
        model = self._model
        return {name: float(_field(model, name)[0]) for name in self.free}

    def machine(self, true: Mapping[str, float]) -> MujocoMachine:
        """The machine with given masses and dampings."""
        model = copy.copy(self._model)
        for name, value in true.items():
            field = _field(model, name)
            if name.endswith(".mass"):
                model.body(name.removesuffix(".mass")).inertia[:] *= value / field[0]
            field[0] = value
        return MujocoMachine.of(model)

    @cached_property
    def _model(self) -> mujoco.MjModel:
        model = mujoco.MjModel.from_xml_path(str(Path(self.mjcf)))
        if model.nq != model.nv or model.nv != model.njnt or model.nu != model.nactuator:
            raise ModelError(f"{self.mjcf}: a plant is made of hinges and slides, with one command to each actuator.")
        for option, value in _PRECISE.items():
            setattr(model.opt, option, value)
        return model


def _field(model: mujoco.MjModel, name: str) -> Array:
    """Where a free parameter stands in the compiled model, shape (1,)."""
    element, _, attribute = name.rpartition(".")
    return model.body(element).mass if attribute == "mass" else model.joint(element).damping


def _about(offset: Array) -> Array:
    """Inertia of a unit mass at an offset, shape (3, 3)."""
    return float(offset @ offset) * np.eye(3) - np.outer(offset, offset)


def _principal(tensor: Array) -> tuple[Array, Array]:
    """Principal moments of inertia, and the quaternion of their axes."""
    moments, axes = np.linalg.eigh(tensor)
    turn = np.zeros(4)
    mujoco.mju_mat2Quat(turn, (axes * np.sign(np.linalg.det(axes))).reshape(-1))
    return moments, turn
