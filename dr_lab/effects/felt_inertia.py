"""What of a body's inertia the joints of a model feel."""

from collections.abc import Iterator
from copy import copy

import mujoco
import numpy as np

from dr_lab.effects.generalised_forces import inverse_forces
from dr_lab.physics.pseudo_inertia import principal, second_moments
from dr_lab.trajectory import Array

_REACH, _SIZE = 0.3, 0.2  # m, of the bodies that are tried; any would do


def felt(model: mujoco.MjModel, name: str, poses: int, least: float) -> bool:
    """Whether the joints feel all ten inertial parameters of what is fixed to a body: mass, centre and inertia.

    Args:
        model: the compiled model.
        name: of the body.
        poses: number of states in motion that are looked at.
        least: the ten count as felt if the weakest combination of them is above this share of the strongest.
    """
    columns = _columns(model, model.body(name).id, poses)
    sizes = np.linalg.svd(columns / np.maximum(np.linalg.norm(columns, axis=0), mujoco.mjMINVAL), compute_uv=False)
    return len(sizes) == columns.shape[1] and bool(sizes[-1] > least * sizes[0])


def _columns(model: mujoco.MjModel, body: int, poses: int) -> Array:
    """Generalised forces of ten loads whose inertial parameters span all that there are, shape (poses · nv, 10)."""
    plain = inverse_forces(model, poses).ravel()
    return np.stack([inverse_forces(_with(model, body, *load), poses).ravel() - plain for load in _loads()], axis=1)


def _loads() -> Iterator[tuple[Array, Array]]:
    """Centre and second moments about it of loads of 1 kg: seven point masses and three rods."""
    points = (np.zeros(3), *np.eye(3), *(1.0 - np.eye(3)))
    yield from ((_REACH * point, np.zeros((3, 3))) for point in points)
    yield from ((np.zeros(3), np.diag(_SIZE**2 * row)) for row in np.eye(3))


def _with(model: mujoco.MjModel, body: int, centre: Array, second: Array) -> mujoco.MjModel:
    """A copy of a model with a load of 1 kg at a body."""
    changed, turned = copy(model), np.zeros(9)
    mujoco.mju_quat2Mat(turned, model.body_iquat[body])
    axes, mass, own = turned.reshape(3, 3), float(model.body_mass[body]), model.body_ipos[body]
    inertia = axes @ np.diag(model.body_inertia[body]) @ axes.T
    place = (mass * own + centre) / (mass + 1.0)
    spread = second_moments(inertia) + second
    spread = spread + mass * np.outer(own - place, own - place) + np.outer(centre - place, centre - place)
    changed.body_inertia[body], changed.body_iquat[body] = principal(spread)
    changed.body_sameframe[body], changed.body_simple[body] = 0, 0  # its centre is nowhere special any more
    changed.body_mass[body], changed.body_ipos[body] = mass + 1.0, place
    return changed
