"""Bodies that touch all the time because their shapes overlap: no contact of the machine."""

from collections import Counter

import mujoco
import numpy as np

from dr_lab.proposal.output import Positions
from dr_lab.trajectory import Array

_LOOKED_AT = 200  # places of the motion
_TRIED = 50  # places of a robot whose motion is not known
_AROUND = 0.3  # rad or m, about the reference


def overlaps(model: mujoco.MjModel, found: Positions, share: float) -> tuple[tuple[str, str], ...]:
    """Pairs of bodies that touch in nearly the whole motion.

    Args:
        model: compiled, with contacts.
        found: what is known of the motion.
        share: of the motion in which they touch.
    """
    data, touching = mujoco.MjData(model), Counter[tuple[int, int]]()
    places = _places(model, found)
    for qpos in places:
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_collision(model, data)
        bodies = model.geom_bodyid[data.contact.geom[data.contact.dist < 0]]
        touching.update({(int(min(pair)), int(max(pair))) for pair in bodies if min(pair) >= 0})
    standing = bool((model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)).any())
    return tuple(
        (model.body(a).name, model.body(b).name)
        for (a, b), count in sorted(touching.items())
        if count >= share * len(places) and not (standing and a == 0)
    )


def _places(model: mujoco.MjModel, found: Positions) -> Array:
    if found.trial is not None and found.found is not None and not found.trial.rates:
        qpos = found.trial.motion(found.found.readings).qpos
        return qpos[:: len(qpos) // _LOOKED_AT + 1]
    rng = np.random.default_rng(0)
    data, places = mujoco.MjData(model), []
    for _ in range(_TRIED):
        data.qpos[:] = model.qpos0
        mujoco.mj_integratePos(model, data.qpos, rng.uniform(-_AROUND, _AROUND, model.nv), 1.0)
        places.append(data.qpos.copy())
    return np.array(places)
