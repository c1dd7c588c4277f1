"""Windows for the same model at a coarser time step."""

from dataclasses import replace

import numpy as np

from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.trajectory import Array


def coarser(windows: Windows, parts: int) -> Windows:
    """The same windows at a step that is `parts` of theirs; over it, commands and the motion before are their means.

    Steps before a window are grouped from its start on, and the oldest that fill no group are left out; the last step
    of a window lasts as long as the others. A delay that is no multiple of the coarser step is rounded.
    """
    before, missing = windows.before, windows.unlogged
    means = {name: _before(getattr(before, name), parts) for name in ("qpos", "qvel", "controls")}
    return replace(
        windows,
        controls=_after(windows.controls, parts, 1),
        past=_before(windows.past, parts),
        before=replace(before, **means),
        unlogged=missing and replace(missing, size=_after(missing.size, parts, 2)),
        step=windows.step * parts,
    )


def _before(values: Array, parts: int) -> Array:
    """Means of groups of steps, shape (w, p, …), the last of which ends at the start."""
    count = values.shape[1] // parts
    whole = values[:, values.shape[1] - count * parts :]
    return whole.reshape(len(values), count, parts, *values.shape[2:]).mean(axis=2)


def _after(values: Array, parts: int, axis: int) -> Array:
    """Means of groups of steps along an axis; what the last group lacks repeats the last step."""
    lacking = -values.shape[axis] % parts
    last = np.repeat(np.take(values, [-1], axis), lacking, axis)
    whole = np.concatenate([values, last], axis)
    shape = (*values.shape[:axis], -1, parts, *values.shape[axis + 1 :])
    return whole.reshape(shape).mean(axis=axis + 1)
