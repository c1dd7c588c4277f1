"""Single samples that a motion cannot have made."""

import numpy as np
from numpy.typing import NDArray

from dr_lab.measurements.cleaning import Cleaned
from dr_lab.measurements.contract import DataContract
from dr_lab.trajectory import Array, Note

# Neighbours on each side through which the quadratic goes.
_SIDE = 4
_DEGREE = 2
# Of two glitches within two samples, the smaller shows only when the larger is gone.
_PASSES = 3


def drop_glitches(
    name: str, time: Array, value: Array, noise_std: float, longest_wait: float, contract: DataContract
) -> Cleaned:
    """Drop samples that lie far from the curve of their neighbours, while those neighbours lie on it.

    A sample is suspected if it lies further than `contract.glitch` noise standard deviations from the cubic through the
    two samples on each side, and further than those samples lie from theirs. A quadratic through its four nearest
    unsuspected neighbours on each side, all but the worst of them, then decides: the sample is a glitch if it lies
    further from it than `contract.glitch` times the noise and `contract.glitch_contrast` times the scatter of those
    neighbours. A reversal under Coulomb friction, an impact or a step bends the neighbours too (a kink lies 5 times
    their scatter away).

    Args:
        name: of the channel.
        time: s, shape (n,).
        value: shape (n,).
        noise_std: of the channel.
        longest_wait: s, neighbours across longer times between samples are not asked.
        contract: thresholds.

    Returns:
        The samples that remain; with more glitches than `contract.glitch_share` all of them, and a note that says so.

    Source: the decision by a robust deviation from the neighbours follows Hampel 1974.
    """
    keep = np.ones(len(time), dtype=np.bool_)
    for _ in range(_PASSES):
        suspects = _suspects(time[keep], value[keep], contract.glitch * noise_std)
        wrong = _confirmed(time[keep], value[keep], suspects, noise_std, longest_wait, contract)
        if not wrong.any():
            break
        keep[np.flatnonzero(keep)[wrong]] = False
    return _removed(name, time, value, keep, contract)


def _removed(name: str, time: Array, value: Array, keep: NDArray[np.bool_], contract: DataContract) -> Cleaned:
    count = int((~keep).sum())
    if count == 0:
        return Cleaned(time, value, ())
    if count > contract.glitch_share * len(time):
        message = (
            f"{name}: {count} of {len(time)} samples look like glitches, too many to be accidents; none was removed. "
            "Check the sensor, or give noise_std."
        )
        return Cleaned(time, value, (Note("glitches", name, message, count),))
    message = f"{name}: {count} glitches were removed, the first at {float(time[keep.argmin()]):.3g} s."
    return Cleaned(time[keep], value[keep], (Note("glitches", name, message, count),))


def _suspects(time: Array, value: Array, limit: float) -> NDArray[np.bool_]:
    off = np.zeros(len(time))
    if len(time) > 4:
        index = np.arange(2, len(time) - 2)
        sides = [index - 2, index - 1, index + 1, index + 2]
        # Lagrange's weights of the cubic through the four, at the sample between them.
        weights = [
            np.prod([(time[index] - time[k]) / (time[j] - time[k]) for k in sides if k is not j], axis=0) for j in sides
        ]
        off[2:-2] = np.abs(value[index] - np.sum([w * value[j] for w, j in zip(weights, sides, strict=True)], axis=0))
    padded = np.pad(off, 2)
    highest = np.max([padded[k : k + len(off)] for k in range(5)], axis=0)
    return (off > limit) & (off == highest)


def _confirmed(
    time: Array,
    value: Array,
    suspects: NDArray[np.bool_],
    noise_std: float,
    longest_wait: float,
    contract: DataContract,
) -> NDArray[np.bool_]:
    trusted = np.flatnonzero(~suspects)
    wrong = np.zeros(len(time), dtype=np.bool_)
    at = np.flatnonzero(suspects)
    place = np.searchsorted(trusted, at)
    inside = (place >= _SIDE) & (place + _SIDE <= len(trusted))
    at, place = at[inside], place[inside]
    neighbours = trusted[place[:, None] + np.arange(-_SIDE, _SIDE)]
    near = time[neighbours[:, -1]] - time[neighbours[:, 0]] <= 2 * _SIDE * longest_wait
    at, neighbours = at[near], neighbours[near]
    off, scatter = _from_curve(time[neighbours] - time[at][:, None], value[neighbours] - value[at][:, None])
    wrong[at] = (off > contract.glitch * noise_std) & (off > contract.glitch_contrast * scatter)
    return wrong


def _from_curve(x: Array, y: Array) -> tuple[Array, Array]:
    """Distance of the origin from quadratics through all neighbours but one, and the scatter of those about it.

    The neighbour left out is the one without which they scatter least: it may be a glitch itself.
    """
    x = x / np.abs(x).max(axis=1, initial=0.0, keepdims=True)
    fits = []
    for drop in range(x.shape[1]):
        basis = np.delete(x, drop, axis=1)[..., None] ** np.arange(_DEGREE + 1)
        rest = np.delete(y, drop, axis=1)
        coefficients = (np.linalg.pinv(basis) @ rest[..., None])[..., 0]
        residual = rest - (basis @ coefficients[..., None])[..., 0]
        scatter = np.sqrt((residual**2).sum(axis=1) / (rest.shape[1] - _DEGREE - 1))
        fits.append((np.abs(coefficients[:, 0]), scatter))
    distances, scatters = (np.stack(part) for part in zip(*fits, strict=True))
    best = scatters.argmin(axis=0)
    every = np.arange(x.shape[0])
    return distances[best, every], scatters[best, every]
