"""How far a simulated course is from a real one that began alike."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import mujoco
import numpy as np
from scipy.ndimage import gaussian_filter1d
from tensordict import TensorDict
from torch import Tensor

from dr_lab.bounds import NotNegative, require_bounds
from dr_lab.channel_names import POSITION, quantity
from dr_lab.distribution_learners.simopt.quantity import Quantity, quantities
from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Discrepancy:
    """Weighted ℓ1 and squared ℓ2 distance of what is measured at both.

        D = w₁ Σ_t |W e_t| + w₂ Σ_t ‖W e_t‖²,    e = G ∗ (simulated − real),

    G being a Gaussian over time, which forgives small shifts in time. It acts on the difference, that is on both
    courses alike; the paper filters "the distance". A simulation that ends before the machine does stays where it
    ended, and what it does after the machine's end does not count.

    Source: Chebotar et al. 2019, equation 4 and appendix.

    Attributes:
        weights: W by what is measured, ``<joint>.position`` or ``<joint>.velocity`` or what the task says that it sees
            (`Task.measured`), per rad, m, rad/s or m/s; None measures the positions of all hinges and slides, with
            weight 1.
        l1: w₁.
        l2: w₂.
        smoothing: standard deviation of G in control steps; 0 filters nothing.
        truncation: where G is cut off, standard deviations.

    Raises:
        ConfigError: a number is out of its range.
    """

    weights: Mapping[str, float] | None
    l1: NotNegative
    l2: NotNegative
    smoothing: NotNegative
    truncation: NotNegative

    def __post_init__(self) -> None:
        require_bounds(self, "distribution_learner.discrepancy")

    def measured(self, compiled: mujoco.MjModel, seen: Mapping[str, int]) -> dict[Quantity, float]:
        """W of each quantity that is measured.

        Args:
            compiled: the machine.
            seen: what the task sees besides, `Task.measured`.

        Raises:
            UnknownNameError: a name is no quantity of the machine.
            ConfigError: nothing is measured.
        """
        known = quantities(compiled, seen)
        weights = {name: 1.0 for name in known if quantity(name) == POSITION} if self.weights is None else self.weights
        for name in weights:
            if name not in known:
                raise UnknownNameError("measured quantity", name, known, "the machine (discrepancy.weights)")
        if not any(weights.values()):
            raise ConfigError(
                "distribution_learner.discrepancy.weights measures nothing. Give a weight above 0 to one of: "
                f"{', '.join(known) or 'none, for the machine has neither hinge nor slide'}."
            )
        return {known[name]: weight for name, weight in weights.items()}

    def __call__(self, measured: Mapping[Quantity, float], real: TensorDict, simulated: TensorDict) -> Array:
        """D of each simulated episode from a real one.

        Args:
            measured: as the method of this name gives it.
            real: size [T].
            simulated: size [k, t].

        Returns:
            D, shape (k,).
        """
        weight, length = np.array(list(measured.values())), int(cast(Tensor, real["mask"]).sum())
        away = courses(list(measured), simulated, length) - courses(list(measured), real[None], length)
        if self.smoothing > 0.0:
            away = gaussian_filter1d(away, self.smoothing, axis=1, mode="nearest", truncate=self.truncation)
        return (self.l1 * np.abs(weight * away) + self.l2 * np.square(weight * away)).sum(axis=(1, 2))


def courses(measured: Sequence[Quantity], played: TensorDict, steps: int) -> Array:
    """What is measured of episodes, size [k, t], after each control step, shape (k, steps, c); the last value stays."""
    length = cast(Tensor, played["mask"]).sum(1).numpy()
    row = np.minimum(np.arange(steps), np.maximum(length, 1)[:, None] - 1)
    found = [cast(Tensor, played["next", each.key])[..., each.column].double().numpy() for each in measured]
    return np.take_along_axis(np.stack(found, -1), row[..., None], axis=1)
