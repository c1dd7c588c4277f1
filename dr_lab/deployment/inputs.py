"""What each input of a policy is: told by episodes, in which it equals what is known of the state."""

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from dr_lab.physics.parameter import Parameter
from dr_lab.recorders.episode import Episode
from dr_lab.recorders.joint_labels import columns
from dr_lab.reports.quantity import titled
from dr_lab.trajectory import Array

_ROUNDING = 1e-5  # of float32, beside the value


def inputs_of(episodes: Sequence[Episode], shown: Sequence[Parameter]) -> tuple[str | None, ...]:
    """Each column of the observation in words; None where it is neither of the state nor of the context.

    A column is called what it equals at all instants of all episodes: a position or velocity of a joint, or the sine or
    cosine of an angle. What a task makes of several of these stays unknown.

    Args:
        episodes: at least one, in whatever contexts.
        shown: parameters of the context that follow what the task lets the policy see, in their order; empty where the
            policy does not see it.
    """
    seen = np.concatenate([episode.observation for episode in episodes])
    known = list(_known(episodes))
    count = seen.shape[1] - len(shown)
    found = [_named(seen[:, i], known) for i in range(count)]
    return (*found, *(f"{p.name}: ({_value(p)} − {p.low:g}) / {p.high - p.low:g}" for p in shown))


def _value(parameter: Parameter) -> str:
    return f"value in {parameter.unit}" if parameter.unit not in ("", "1") else "value"


def _named(column: Array, known: Sequence[tuple[str, Array]]) -> str | None:
    """What a column equals, and the nearest of several: a small angle is its own sine but for a little."""
    same = (each for each in known if np.allclose(column, each[1], rtol=_ROUNDING, atol=_ROUNDING))
    apart = {name: float(np.abs(column - value.astype(column.dtype)).max()) for name, value in same}
    return min(apart, key=apart.__getitem__, default=None) if np.ptp(column) > 0 else None


def _known(episodes: Sequence[Episode]) -> Iterator[tuple[str, Array]]:
    """Names and values over all instants of what an input may be, the plainest first."""
    model = episodes[0].geometry
    positions, velocities = columns(model)
    qpos, qvel = (np.concatenate([getattr(episode, key) for episode in episodes]) for key in ("qpos", "qvel"))
    yield from ((titled(*column), qpos[:, i]) for i, column in enumerate(positions))
    yield from ((titled(*column), qvel[:, i]) for i, column in enumerate(velocities))
    for row in np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE):
        name, angle = positions[model.jnt_qposadr[row]][0], qpos[:, model.jnt_qposadr[row]]
        yield f"sin({name})", np.sin(angle)
        yield f"cos({name})", np.cos(angle)
