"""What the actuators of one joint give it."""

from dataclasses import dataclass

import mujoco
import numpy as np

from dr_lab.trajectory import Array

_STEP = 1e-4  # of controls, rad, m, rad/s and m/s; actuators are affine but for their limits


@dataclass(frozen=True)
class JointDrive:
    """tau = constant + by_control · u + by_position q + by_velocity v, which every memoryless actuator follows.

    Limits of controls and forces are not in it, nor is what delays and activations hold back.

    Attributes:
        address: of the joint's position in qpos.
        dof: of the joint.
        constant: generalised force at rest at the origin without a command, N·m or N.
        by_control: of each control, shape (nu,).
        by_position: N·m/rad or N/m.
        by_velocity: N·m·s/rad or N·s/m.
    """

    address: int
    dof: int
    constant: float
    by_control: Array
    by_position: float
    by_velocity: float

    @classmethod
    def of(cls, model: mujoco.MjModel, joint: str) -> "JointDrive":
        """The drive of a hinge or slide joint, from differences about the model's initial state."""
        address, dof = int(model.joint(joint).qposadr[0]), int(model.joint(joint).dofadr[0])
        data = mujoco.MjData(model)

        def force(**changed: int) -> float:
            mujoco.mj_resetData(model, data)
            for field, entry in changed.items():
                getattr(data, field)[entry] += _STEP
            mujoco.mj_forward(model, data)
            return float(data.qfrc_actuator[dof])

        still = force()
        by_control = np.array([(force(ctrl=column) - still) / _STEP for column in range(model.nu)])
        by_position, by_velocity = (force(qpos=address) - still) / _STEP, (force(qvel=dof) - still) / _STEP
        constant = still - by_position * float(model.qpos0[address])
        return cls(address, dof, constant, by_control, by_position, by_velocity)

    def force(self, qpos: Array, qvel: Array, control: Array) -> Array:
        """Generalised force in N·m or N of n simulations, shape (n,); arguments of shape (n, nq), (n, nv), (n, nu)."""
        moving = self.by_position * qpos[:, self.address] + self.by_velocity * qvel[:, self.dof]
        return self.constant + control @ self.by_control + moving
