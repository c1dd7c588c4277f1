"""Where a machine that rolls or slides begins a window: on the ground, sunk in as far as its weight presses it."""

from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np

from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.free_start import FreeBody
from dr_lab.diagnosis.windows.ground import Ground
from dr_lab.diagnosis.windows.start_prior import StartPrior
from dr_lab.diagnosis.windows.tangent import SINGULAR, tangent
from dr_lab.trajectory import Array


def grounded(
    prior: StartPrior, bodies: Sequence[FreeBody], model: mujoco.MjModel, settings: WindowSettings
) -> StartPrior:
    """The prior of free bodies that stay on the ground, whose starts stay there, too; as it is for all others.

    Sensors tell a place to a fraction of a millimetre. That is as much as a body sinks into its contacts. A start that
    is fitted there lifts a wheel off or doubles its load, so that the motion jumps with it, and no fit ends.

    1. Near are shapes of a free body's tree and shapes that never move, closer than `settings.footing`. They are the
       same ones in all windows, every free body has some, and no two free bodies are near each other.
    2. The place moves along the contacts until these carry the bodies at rest, their joints locked. Those that carry
       hold as many directions in every window.
    3. The velocity is the nearest one along the ground. Neither moves by more than `settings.lifting` standard
       deviations: limbs that walk, bodies that tumble, and models that are elsewhere than the machine do.

    Then no unknown of the start moves a contact. A machine with closed chains is left as it is.

    Args:
        prior: of all windows.
        bodies: the free bodies.
        model: compiled nominal model.
        settings: footing and lifting.
    """
    known = all(each.position for each in bodies) and np.isfinite(prior.qpos).all() and np.isfinite(prior.qvel).all()
    if prior.tangent is not None or not bodies or not known or not model.opt.gravity.any():
        return prior
    ground, place = Ground(model, [each.body for each in bodies], settings.footing), prior.std[: model.nv]
    near = {ground.near(q) for q in prior.qpos}
    if len(near) > 1 or None in near:
        return prior
    found = [
        _settled(ground, *state, prior.std, settings.lifting) for state in zip(prior.qpos, prior.qvel, strict=True)
    ]
    kept = [each for each in found if each is not None]
    if len(kept) < len(found):
        return prior
    qpos, qvel, held = zip(*kept, strict=True)
    if len({int(np.linalg.matrix_rank(rows * place, rtol=SINGULAR)) for rows in held}) > 1:
        return prior
    directions = tangent(held, prior.std)
    std = np.ones(directions.basis.shape[2])
    return replace(prior, qpos=np.stack(qpos), qvel=np.stack(qvel), std=std, tangent=directions, grounded=True)


def _settled(ground: Ground, q: Array, v: Array, std: Array, most: float) -> tuple[Array, Array, Array] | None:
    """Positions, velocities, and rows of the contacts, of a start on the ground; None where it is too far away."""
    place, speed = std.reshape(2, -1)
    rest = ground.settled(q, place, most)
    if rest is None:
        return None
    back = np.linalg.lstsq(rest[1] * speed, rest[1] @ v, rcond=SINGULAR)[0]
    return (rest[0], v - speed * back, rest[1]) if np.linalg.norm(back) <= most else None
