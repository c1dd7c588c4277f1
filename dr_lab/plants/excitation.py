"""What is asked of an actuator in one experiment."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from dr_lab.bounds import FINITE, RISING, Count, NotNegative, Positive, above, numbers
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class SinesAndSteps:
    """u(t) = clip(peak · e(t) / max |e|, ± limit), e = Σ aᵢ sin(2π fᵢ t + φᵢ) + steps(t).

    Frequencies are drawn evenly in log f, one from each of as many bands as there are sines, so that slow and fast
    motions both occur; amplitudes lie in [½, 1]. The steps are levels drawn from [−share, share], each held for a time
    drawn from `hold` and then reversed for as long, so that they do not carry the machine away.

    Attributes:
        sines: number of sines.
        lowest: lowest frequency in Hz.
        highest: highest frequency in Hz.
        step_share: largest step relative to the largest sine.
        hold: shortest and longest time in s that a step is held.
        limit: size that the command never exceeds, in its unit; None sets no limit.
    """

    sines: Count
    lowest: Positive
    highest: Positive
    step_share: NotNegative
    hold: Annotated[Sequence[float], numbers(2, FINITE, above(0.0)), RISING]
    limit: Annotated[float | None, above(0.0)]

    def command(self, time: Array, peak: float, generator: np.random.Generator) -> Array:
        """The command at each time, in the peak's unit.

        Args:
            time: s, increasing, shape (n,).
            peak: largest |u| before clipping.
            generator: source of frequencies, phases and steps.
        """
        bands = (np.arange(self.sines) + generator.uniform(size=self.sines)) / self.sines
        frequency = self.lowest * (self.highest / self.lowest) ** bands
        amplitude = generator.uniform(0.5, 1.0, self.sines)
        phase = generator.uniform(0.0, 2 * np.pi, self.sines)
        waves = amplitude @ np.sin(2 * np.pi * np.outer(frequency, time) + phase[:, None])
        wish = waves + self._steps(time, generator)
        limit = np.inf if self.limit is None else self.limit
        return np.clip(peak * wish / np.abs(wish).max(), -limit, limit)

    def _steps(self, time: Array, generator: np.random.Generator) -> Array:
        shortest, longest = self.hold
        most = int(np.ceil((time[-1] - time[0]) / (2 * shortest))) + 1
        holds = np.repeat(generator.uniform(shortest, longest, most), 2)
        levels = np.repeat(generator.uniform(-self.step_share, self.step_share, most), 2)
        levels[1::2] *= -1
        ends = time[0] + np.cumsum(holds)
        return levels[np.searchsorted(ends, time, side="right")]
