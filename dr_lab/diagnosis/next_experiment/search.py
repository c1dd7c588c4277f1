"""The search for the best experiment of a family that keeps all limits: draws, sizing, generations, refits."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.diagnosis.next_experiment.aims import Aim
from dr_lab.diagnosis.next_experiment.machine import Contender, ExperimentMachine
from dr_lab.diagnosis.next_experiment.settings import ExperimentSettings
from dr_lab.diagnosis.next_experiment.sizes import Sizes
from dr_lab.diagnosis.next_experiment.trial import STABLE, tried
from dr_lab.diagnosis.next_experiment.worth import Shots
from dr_lab.seeding import stream
from dr_lab.trajectory import Array

_LEAST_JUDGED = 2  # experiments, of which one is the best


@dataclass(frozen=True)
class Found:
    """An experiment that keeps all limits.

    Attributes:
        values: commands, shape (m, k).
        time: when they are sent, s, shape (k,).
        value: by the aim.
        taken: largest share of any kept limit that the simulated motions take.
        shown: what each contender shows.
    """

    values: Array
    time: Array
    value: float
    taken: float
    shown: Sequence[Shots]


@dataclass(frozen=True)
class NothingFound:
    """No experiment of the family keeps all limits.

    Attributes:
        reason: which limit the gentlest leaves, in words.
    """

    reason: str


@dataclass
class _Archive:
    """Experiments that were simulated, shapes (n, …)."""

    genes: Array
    values: Array
    worth: Array

    def add(self, genes: Array, values: Array, worth: Array) -> None:
        self.genes = np.concatenate([self.genes, genes])
        self.values = np.concatenate([self.values, values])
        self.worth = np.concatenate([self.worth, worth])


class Search:
    """The search for one aim on one machine.

    Args:
        aim: what makes an experiment good.
        machine: on which it is played.
        settings: of the search.
        duration: of the experiments, s.
    """

    def __init__(self, aim: Aim, machine: ExperimentMachine, settings: ExperimentSettings, duration: float) -> None:
        self._aim = aim
        self._machine = machine
        self._settings = settings
        self._time = machine.command_times(duration)
        self._duration = float(self._time[-1])
        share = settings.share_with_laws if any(each.model.lawful for each in aim.contenders) else 1.0
        self._simulations, self._refitted = (
            max(1, round(share * count)) for count in (settings.simulations, settings.refitted)
        )
        self._generator = stream(settings.seed, "next_experiment", f"{duration:g}")
        self._gentlest, self._reason = np.inf, STABLE

    def run(self) -> Found | NothingFound:
        """The best experiment."""
        archive = self._searched()
        found: list[Found] = []
        for row in np.argsort(-archive.worth):
            if len(found) == self._refitted or not np.isfinite(archive.worth[row]):
                break
            safe = self._safe(archive.values[row])
            if safe is not None:
                found.append(safe)
        best = max(found, key=lambda each: each.value, default=None)
        if best is None:
            return NothingFound(self._reason)
        return best if np.isfinite(best.value) else NothingFound(STABLE)  # in every refit a window diverges

    def _searched(self) -> _Archive:
        settings, machine = self._settings, self._machine
        genes = settings.family.draw(settings.population, len(machine.names), self._generator)
        archive = _Archive(genes[:0], self._values(genes[:0]), np.zeros(0))
        for generation in range(settings.generations):
            genes = self._sized(genes)
            values = self._values(genes)
            shown, excess = self._tried(values, self._aim.quick, 0, settings.look)
            archive.add(genes, values, self._worth(shown, excess))
            if generation + 1 < settings.generations:
                genes = self._children(archive)
        return archive

    def _values(self, genes: Array) -> Array:
        return self._settings.family.commands(genes, self._time, self._machine.bounds)

    def _sized(self, genes: Array) -> Array:
        """The experiments at the largest size that keeps the limits by the fitted models; every third one no larger.

        A small motion may tell more, as of a dead zone; so not all are as large as they may be.
        """
        settings, family = self._settings, self._settings.family
        sizes = Sizes(len(genes), settings.sizing)
        sizes.most[1::3] = 1.0
        for _ in range(settings.sizing.tries):
            _, excess = self._tried(self._values(family.resized(genes, sizes.next)), self._aim.quick, 0, settings.look)
            sizes.seen(excess)
        return family.resized(genes, sizes.kept)

    def _worth(self, shown: Sequence[Shots], excess: Array) -> Array:
        """Worth of those that promise most of the experiments that keep the limits, −∞ of the others."""
        found, most = np.full(len(excess), -np.inf), self._simulations // self._aim.simulations
        able = np.flatnonzero(excess <= 1)
        if len(able) > (most := max(_LEAST_JUDGED, most)):
            order = able[np.argsort(-self._aim.hint(shown)[able])]
            able = np.concatenate([order[: (most + 1) // 2], self._generator.permutation(order[(most + 1) // 2 :])])[
                :most
            ]
        best = [int(k) for k in able]
        if best:
            found[best] = self._aim.worth([each.pick(best) for each in shown])
        return found

    def _children(self, archive: _Archive) -> Array:
        """A generation of the best so far."""
        settings, generator = self._settings, self._generator
        elite = np.argsort(-archive.worth)[: max(2, settings.elite)]
        one, other = elite[generator.integers(len(elite), size=(2, settings.population))]
        shape = archive.genes[one].shape
        genes = np.where(generator.uniform(size=shape) < 0.5, archive.genes[one], archive.genes[other])
        moved = (generator.uniform(size=shape) < settings.mutated) * generator.normal(
            scale=settings.mutation, size=shape
        )
        return settings.family.mutated(genes, moved)

    def _safe(self, values: Array) -> Found | None:
        """An experiment, as large as it may be in all drawn contexts, with its value; None where it is in none."""
        settings, hold = self._settings, self._machine.bounds.hold[:, None]
        scaled = np.stack([hold + scale * (values - hold) for scale in settings.scales])
        shown, excess = self._tried(scaled, self._aim.contenders, settings.safety.draws, settings.fine_look)
        rows = np.flatnonzero(excess <= 1)
        if not len(rows):
            return None
        row = int(rows[0])
        kept = [each.pick([row]) for each in shown]
        return Found(scaled[row], self._time, self._aim.value(kept), float(excess[row]), kept)

    def _tried(
        self, values: Array, contenders: Sequence[Contender], drawn: int, looks: float
    ) -> tuple[list[Shots], Array]:
        """What each contender shows of experiments, and the largest share that these take of any limit."""
        experiments, shown, excess = self._machine.signals(values, self._time), [], np.zeros(len(values))
        for contender in contenders:
            z = contender.drawn(drawn, self._settings.safety.spread, self._generator)
            trial = tried(contender, z, experiments, self._machine, looks)
            shown.append(Shots(experiments, trial.outputs, self._duration))
            excess = np.maximum(excess, trial.excess)
            gentlest = int(trial.excess.argmin())
            if 1 < trial.excess[gentlest] < self._gentlest:
                self._gentlest, self._reason = float(trial.excess[gentlest]), trial.worst[gentlest]
        return shown, excess
