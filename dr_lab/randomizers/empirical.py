"""Contexts out of those that were seen, each as likely as any other."""

from collections.abc import Mapping, Sequence

import numpy as np
import torch
from torch import Tensor

from dr_lab.bounds import Count, require_bounds
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.randomizer import Randomizer, bin_shares
from dr_lab.randomizers.uniform import box
from dr_lab.trajectory import Array


class EmpiricalRandomizer(Randomizer):
    """z is one of the contexts noted within the newest `window` of control steps; before any, uniform within a box.

    There is no density and nothing to differentiate: whoever learns notes what it proposes.

    Args:
        space: the parameters.
        ranges: [low, high] of the box in SI units by parameter; those not named take the space's bounds.
        window: control steps.
        bins: of each parameter's range, in pictures.

    Raises:
        UnknownNameError: a name is not a parameter.
        ConfigError: a range is not ordered, or a number is too small.
    """

    low: Tensor
    high: Tensor

    def __init__(
        self, space: ContextSpace, ranges: Mapping[str, Sequence[float]] | None, window: Count, bins: Count
    ) -> None:
        super().__init__(space)
        self.window, self.bins = window, bins
        require_bounds(self, "randomizer", EmpiricalRandomizer)
        low, high = box(space, ranges)
        self.register_buffer("low", low)
        self.register_buffer("high", high)
        self._noted = np.zeros((0, len(low)))
        self._frames = np.zeros(0, np.int64)  # when each was

    def note(self, z: Array, frames: int) -> None:
        """Take contexts (k, n) into account, and forget those that are older than the window.

        Args:
            z: the contexts.
            frames: control steps of training so far.
        """
        noted = np.concatenate([self._noted, z])
        when = np.concatenate([self._frames, np.full(len(z), frames, np.int64)])
        kept = when > frames - self.window
        self._noted, self._frames = noted[kept], when[kept]

    def sample(self, rngs: Sequence[np.random.Generator]) -> Array:
        """One of the noted contexts a stream."""
        width = len(self.low)
        if len(self._noted):
            return self._noted[[int(rng.integers(len(self._noted))) for rng in rngs]].reshape(len(rngs), width)
        unit = np.array([rng.random(width) for rng in rngs]).reshape(len(rngs), width)
        return self.low.numpy() + unit * (self.high - self.low).numpy()

    def edges(self, axis: int) -> Array:
        """Of `bins` bins that fill the box."""
        return np.linspace(float(self.low[axis]), float(self.high[axis]), self.bins + 1)

    def shares(self, axis: int, edges: Array) -> Array:
        """Share of the noted contexts in each bin, exact."""
        if len(self._noted):
            return np.histogram(np.clip(self._noted[:, axis], edges[0], edges[-1]), edges)[0] / len(self._noted)
        low, high = float(self.low[axis]), float(self.high[axis])
        return bin_shares(np.clip((edges - low) / (high - low), 0.0, 1.0))

    def moments(self) -> None:
        """None: contexts that were sought often lie in several places, of which an ellipse says nothing."""

    def get_extra_state(self) -> dict[str, Tensor]:
        """What is noted, so that `state_dict` says all that the next draw depends on."""
        return {"noted": torch.from_numpy(self._noted), "frames": torch.from_numpy(self._frames)}

    def set_extra_state(self, state: Mapping[str, Tensor]) -> None:
        """Go on with what was noted."""
        self._noted, self._frames = state["noted"].numpy().copy(), state["frames"].numpy().copy()
