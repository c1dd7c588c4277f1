"""The family of experiments that is searched: smooth sums of sines between a soft start and a soft end."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from dr_lab.bounds import Count, Positive, Share, above, at_most, require_bounds
from dr_lab.errors import ConfigError
from dr_lab.trajectory import Array

_LEAST_GENE = -1.0  # of a size: the square of the smallest that is drawn
_MORE = 3  # genes beside those of the sines: the edge, the middle and the size


@dataclass(frozen=True)
class Bounds:
    """What each command may be; all of shape (m,).

    Attributes:
        hold: with which the machine stands at its start.
        low: lowest.
        high: highest.
        slew: fastest change a second, infinite where nothing bounds it.
    """

    hold: Array
    low: Array
    high: Array
    slew: Array


@dataclass(frozen=True)
class Multisines:
    """u(t) = hold + w(t) s [(c − hold) + r q(t) / max |w q|], q = tanh(h e / max |e|), r = min(high − c, c − low).

    e = Σ aₖ sin(2π fₖ t + φₖ), with one frequency in each of as many bands of log f as there are sines. The edge h
    makes steps of it, as far as these take some commands each. w rises from 0 to 1 as (1 − cos)/2 in the ramp and falls
    likewise, so that an experiment begins and ends with the commands that hold the machine, without a jump. In between,
    commands at 100 Hz follow one another by less than a third of their range; slower ones, of which few fall into a
    period or a ramp, lie farther apart, up to the whole range at 5 Hz. Where a wave is larger in a ramp than the middle
    is near, what would leave the range is cut off. The genes of one actuator
    lie between 0 and 1: place in its band, phase and amplitude (logarithmic) of every sine, the edge (its root), the
    middle c between low and high, and the size s (logarithmic), which goes below 0 where limits ask for smaller ones.
    Source: windowed Fourier series as in Swevers et al. 1997, Optimal robot excitation and identification.

    Attributes:
        sines: of each command.
        lowest: frequency, Hz.
        highest: frequency, Hz; slow commands allow less.
        ramp: s.
        most_ramp: share of the duration that a ramp takes at most.
        faintest: amplitude of a sine, share of the largest.
        smallest: experiment that is drawn, share of the actuator's range.
        commands_a_period: of the fastest sine's period, at least: held commands then still look like a sine.
        edge: h of the steepest edge.
        jump: largest change of q from a command to the next up to which the edge is made steeper.
    """

    sines: Count
    lowest: Positive
    highest: Positive
    ramp: Positive
    most_ramp: Annotated[float, above(0.0), at_most(0.5)]
    faintest: Share
    smallest: Share
    commands_a_period: Count
    edge: Positive
    jump: Share

    def __post_init__(self) -> None:
        require_bounds(self, "next_experiment.family")
        if self.lowest >= self.highest:
            given = f"lowest is {self.lowest:g}, highest {self.highest:g} Hz"
            raise ConfigError(f"next_experiment.family: {given}; expected lowest below highest.")

    @property
    def genes(self) -> int:
        """Genes of one actuator."""
        return 3 * self.sines + _MORE

    def draw(self, count: int, actuators: int, generator: np.random.Generator) -> Array:
        """Genes at random, shape (count, actuators, genes); every other one is a simple shape about the middle.

        These are in turn the slower sines alone, the faster ones, and steps of one frequency.
        """
        genes, half = generator.uniform(size=(count, actuators, self.genes)), (self.sines + 1) // 2
        amplitude = genes[..., 2 * self.sines : 3 * self.sines]
        slow, fast, steps = (slice(2 * shape, None, 6) for shape in range(3))
        amplitude[slow, :, half:] = 0.0
        amplitude[fast, :, :half] = 0.0
        chosen = amplitude[steps].argmax(axis=-1)
        amplitude[steps] = chosen[..., None] == np.arange(self.sines)
        genes[::2, :, -3], genes[steps, :, -3] = 0.0, 1.0
        genes[::2, :, -2:] = 0.5, 1.0
        return genes

    def mutated(self, genes: Array, change: Array) -> Array:
        """The genes with a change of the same shape, as far as they go."""
        found = np.clip(genes + change, 0.0, 1.0)
        found[..., -1] = np.clip(genes[..., -1] + change[..., -1], _LEAST_GENE, 1.0)
        return found

    def resized(self, genes: Array, factor: Array) -> Array:
        """The genes with all sizes multiplied by a factor above 0, shape (n,), as far as they go."""
        found = genes.copy()
        moved = found[..., -1] - np.log(factor)[:, None] / np.log(self.smallest)
        found[..., -1] = np.clip(moved, _LEAST_GENE, 1.0)
        return found

    def commands(self, genes: Array, time: Array, bounds: Bounds) -> Array:
        """The commands at each time.

        Args:
            genes: shape (n, m, genes).
            time: s, from 0, evenly spaced, shape (k,).
            bounds: of the m commands.

        Returns:
            Shape (n, m, k).
        """
        waves, window = self._waves(genes, time), self._window(time)
        waves = window * self._edged(waves, genes[..., -3])
        waves = waves / np.maximum(np.abs(waves).max(axis=2, keepdims=True), np.finfo(float).tiny)
        middle = bounds.low + (bounds.high - bounds.low) * genes[..., -2]
        room = np.minimum(bounds.high - middle, middle - bounds.low)
        size = self.smallest ** (1 - genes[..., -1])
        moved = size[..., None] * ((middle - bounds.hold)[..., None] * window + room[..., None] * waves)
        fastest = np.abs(np.diff(moved, axis=2)).max(axis=2) / (time[1] - time[0])
        slow = np.minimum(1.0, bounds.slew / np.maximum(fastest, np.finfo(float).tiny))
        wished = bounds.hold[:, None] + slow[..., None] * moved
        return np.clip(wished, bounds.low[:, None], bounds.high[:, None])

    def _waves(self, genes: Array, time: Array) -> Array:
        place, phase, size = (genes[..., k * self.sines : (k + 1) * self.sines] for k in range(3))
        share = (np.arange(self.sines) + place) / self.sines
        fastest = max(self.lowest, min(self.highest, 1 / (self.commands_a_period * (time[1] - time[0]))))
        frequency = self.lowest * (fastest / self.lowest) ** share
        angle = 2 * np.pi * (frequency[..., None] * time + phase[..., None])
        return (self.faintest ** (1 - size[..., None]) * np.sin(angle)).sum(axis=2)

    def _window(self, time: Array) -> Array:
        ramp = min(self.ramp, self.most_ramp * float(time[-1]))
        share = np.clip(np.minimum(time, time[-1] - time) / ramp, 0.0, 1.0)
        return (1 - np.cos(np.pi * share)) / 2

    def _edged(self, waves: Array, gene: Array) -> Array:
        """Waves of the largest value 1 with steeper edges, shapes (…, k) and (…)."""
        waves = waves / np.maximum(np.abs(waves).max(axis=-1, keepdims=True), np.finfo(float).tiny)
        steepest = np.maximum(np.abs(np.diff(waves)).max(axis=-1), self.jump / self.edge)
        edge = np.clip(self.edge * gene**2, 1e-3, np.maximum(self.jump / steepest, 1e-3))
        return np.tanh(edge[..., None] * waves)
