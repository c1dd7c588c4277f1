"""The step of a quantised channel (encoder, converter, printed digits), from its values alone."""

import numpy as np

from dr_lab.trajectory import Array

# A distance is a multiple of the step if it is off by less than this share of it; by chance one in five is.
_OFF = 0.1
_AGREE = 0.95
# Fewest distances that may establish a step; eight random ones agree with a probability of 3e-6.
_LEAST = 8
# Fewest distances that confirm a step which is known; three random ones agree with a probability of 1 %.
_FEW = 3
# Distances up to this many steps establish the step before longer ones refine it.
_NEAR = 20
# Samples of a long signal that are looked at.
_MOST = 50_000
# A uniform motion takes its samples a step apart, too: more than this share of its changes are single steps …
_SINGLE = 0.95
# … and its speed changes by a step in fewer than this share of them. The rounding of a moving signal alternates.
_BENT = 0.2
# A change of none or of two steps between single ones is what a lattice makes; more than chance makes so many.
_ISOLATED = 3


def lattice_step(value: Array) -> float | None:
    """Find the step q of values that lie on a lattice v_0 + k q.

    Values that differ by less than a tenth of a step count as one point of the lattice, so that rounding in a file's
    digits does no harm. Of the steps that explain the distances between neighbouring points, the largest is taken. The
    way of a uniform motion from sample to sample is no step.

    Args:
        value: samples in the order of time, shape (n,).

    Returns:
        The step in the values' unit, or None if the values are constant or continuous.
    """
    samples = value[:: len(value) // _MOST + 1]
    samples = samples[np.isfinite(samples)]
    points = np.unique(samples)
    if len(points) < 2:
        return None
    distances = np.diff(points)
    # A fast motion never lands on neighbouring points, but its distances differ by single steps.
    distances = np.concatenate([distances, np.diff(np.unique(distances))])
    distances = distances[distances > 1e-12 * np.abs(points).max()]
    if len(distances) == 0:
        return None
    octaves = np.floor(np.log2(distances))
    starts = [float(distances[octaves == octave].min()) for octave in np.unique(octaves)]
    found = [step for start in starts if (step := _confirm(points, distances, start))]
    return max((step for step in found if not _uniform_motion(samples, step)), default=None)


def on_lattice(value: Array, step: float) -> bool:
    """Whether values that may be too few to tell a step of their own lie on a lattice with this one.

    Args:
        value: samples, shape (n,).
        step: in the values' unit.
    """
    points = np.unique(value[np.isfinite(value)])
    multiples = np.diff(points) / step
    multiples = multiples[multiples > _OFF]
    return len(multiples) >= _FEW and bool((np.abs(multiples - np.rint(multiples)) < _OFF).mean() >= _AGREE)


def _uniform_motion(samples: Array, step: float) -> bool:
    """Whether the step is the way of a uniform motion from sample to sample.

    On a lattice the changes from sample to sample are 0, 1, 2 … steps by turns, as the motion asks for; near one step a
    sample few of them are none or two, each between single ones. A motion that makes a lattice of its own samples goes
    on by one step each time, or stands still.
    """
    changes = np.rint(np.diff(samples) / step)
    moved = changes != 0
    if not moved.any() or (np.abs(changes[moved]) == 1).mean() < _SINGLE:
        return False
    same = (np.abs(changes[:-2]) == 1) & (changes[:-2] == changes[2:])
    if (same & (changes[1:-1] != changes[:-2])).sum() >= _ISOLATED:
        return False
    bent = np.diff(changes) != 0
    return bool(bent.sum() < _BENT * moved.sum())


def _confirm(points: Array, distances: Array, start: float) -> float | None:
    """Refine a first guess, or reject it."""
    near = distances[(distances > 0.5 * start) & (distances < 1.5 * start)]
    if len(near) == 0:
        return None
    step = float(np.median(near))
    centres = _merge(points, step)
    gaps = np.diff(centres)
    if len(gaps) == 0 or (len(gaps) < _LEAST and len(points) > _LEAST):
        return None
    close = gaps[gaps < _NEAR * step]
    if len(close) < 0.5 * min(len(gaps), _LEAST):
        return None
    counts = np.rint(close / step)
    step = float(close @ counts / (counts @ counts))
    multiples = gaps / step
    if (np.abs(multiples - np.rint(multiples)) < _OFF).mean() < _AGREE:
        return None
    return _refine(centres, gaps, step)


def _merge(points: Array, step: float) -> Array:
    """Means of runs of points that lie closer than a tenth of a step."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(points) > _OFF * step) + 1])
    sizes = np.diff(np.append(starts, len(points)))
    return np.add.reduceat(points, starts) / sizes


def _refine(centres: Array, gaps: Array, step: float) -> float:
    """Least squares over the whole range: counts the steps from one end to the other."""
    places = np.concatenate([[0.0], np.cumsum(np.rint(gaps / step))])
    places -= places.mean()
    return float(places @ (centres - centres.mean()) / (places @ places))
