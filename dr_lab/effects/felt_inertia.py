"""What of a body's inertia the joints of a model feel."""

from collections.abc import Iterable, Iterator
from copy import copy

import mujoco
import numpy as np

from dr_lab.effects.generalised_forces import inverse_forces
from dr_lab.effects.load_frame import load_frame
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
    return _told_apart(_columns(model, model.body(name).id, poses, _loads()), least)


def felt_in_plane(model: mujoco.MjModel, name: str, poses: int, least: float) -> bool:
    """Whether the joints feel, of what is fixed to a link, mass, centre across its hinge's axis and inertia about it.

    Args:
        model: the compiled model.
        name: of the link.
        poses: number of states in motion that are looked at.
        least: the four count as felt if the weakest combination of them is above this share of the strongest.
    """
    body = int(model.body(name).id)
    origin, axes, _ = load_frame(model, body)
    points = [(origin + _REACH * axes @ at, np.zeros((3, 3))) for at in np.eye(3)[[2, 0, 1]] * [1.0, 1.0, 0.0]]
    rod = (origin, _SIZE**2 * np.outer(axes[:, 0], axes[:, 0]))
    return _told_apart(_columns(model, body, poses, [*points, rod]), least)


def _told_apart(columns: Array, least: float) -> bool:
    """Whether no combination of some loads goes unfelt, each load being a column of forces."""
    norms = np.linalg.norm(columns, axis=0)
    if norms.min() <= least * norms.max():  # its share would be rounding
        return False
    sizes = np.linalg.svd(columns / norms, compute_uv=False)
    return len(sizes) == columns.shape[1] and bool(sizes[-1] > least * sizes[0])


def _columns(model: mujoco.MjModel, body: int, poses: int, loads: Iterable[tuple[Array, Array]]) -> Array:
    """Generalised forces of loads of 1 kg, by centre and second moments about it, shape (poses · nv, loads)."""
    plain = inverse_forces(model, poses).ravel()
    return np.stack([inverse_forces(_with(model, body, *load), poses).ravel() - plain for load in loads], axis=1)


def _loads() -> Iterator[tuple[Array, Array]]:
    """Loads whose inertial parameters span all that there are: seven point masses and three rods."""
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
