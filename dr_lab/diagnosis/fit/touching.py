"""Whether shapes touch one another in a motion: impacts make a cost jagged."""

import mujoco
import numpy as np

from dr_lab.trajectory import Array

_LOOKS = 20  # times in each window; a foot or a fall stays in contact for longer than a twentieth of it


def touches(model: mujoco.MjModel, qpos: Array) -> bool:
    """Whether shapes touch each other at some of the positions of a motion, shape (w, s, nq)."""
    data = mujoco.MjData(model)
    for position in qpos[:, :: max(1, qpos.shape[1] // _LOOKS)].reshape(-1, model.nq):
        if not np.isfinite(position).all():
            continue
        data.qpos[:] = position
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        if data.ncon:
            return True
    return False


def may_touch(model: mujoco.MjModel) -> bool:
    """Whether the model asks for contacts of any two shapes of different bodies, one of which moves."""
    kinds, others, body = model.geom_contype, model.geom_conaffinity, model.body_weldid[model.geom_bodyid]
    alike = (kinds[:, None] & others[None]) != 0
    asked = ((alike | alike.T) & (body[:, None] != body[None])).any() or model.npair > 0
    return bool(asked) and not model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
