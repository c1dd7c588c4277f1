"""Settings of the next experiment; their values live in conf/next_experiment."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from dr_lab.bounds import Count, Natural, Positive, Share, above, at_most, require_bounds
from dr_lab.diagnosis.next_experiment.family import Multisines
from dr_lab.diagnosis.next_experiment.limits import Safety
from dr_lab.diagnosis.next_experiment.sizes import Sizing
from dr_lab.diagnosis.next_experiment.standing import Stillness
from dr_lab.errors import ConfigError


@dataclass(frozen=True)
class ExperimentSettings:
    """Which experiments are looked for, and how.

    Attributes:
        family: of commands.
        safety: what they must keep.
        durations: s; the first is tried first, the next where no experiment of that length keeps all limits.
        command_rate: commands a second at most, Hz; no more than the logs have.
        sample_rate: samples a second of every channel at most, Hz; no more than the logs have.
        population: experiments that are simulated in a generation.
        generations: how often a new generation is made of the best experiments.
        sizing: how the largest size of each experiment is looked for that keeps the limits.
        elite: the best experiments, of which the next generation is made.
        mutated: share of the genes of a new generation that change.
        mutation: standard deviation of a gene's change.
        scales: of the best experiments: the first that keeps the limits in all contexts drawn is taken.
        simulations: of a generation's experiments in rough refits or linear steps; where these are too few for all,
            those that promise most and others at random share them.
        seconds: s of each experiment on which that is done.
        iterations: steps of a rough refit.
        refitted: the best experiments that are judged by refits in the end.
        share_with_laws: share of the simulations, and of the refits in the end, where laws act from step to step.
        longest_window: share of an experiment's duration that a window takes at most.
        look: s between two looks at the distances of parts.
        fine_look: the same for the best experiments.
        log_look: the same in what the logs show.
        stillness: when a machine stands where it starts.
        poor: share of a parameter's size from which on its standard deviation makes it poorly known.
        least_size: of a parameter, share of the width of its bounds.
        seed: of the search.

    Raises:
        ConfigError: a number is too small, or there is no duration.
    """

    family: Multisines
    safety: Safety
    durations: Sequence[float]
    command_rate: Positive
    sample_rate: Positive
    population: Count
    generations: Count
    sizing: Sizing
    elite: Count
    mutated: Share
    mutation: Positive
    scales: Sequence[float]
    simulations: Count
    seconds: Positive
    iterations: Count
    refitted: Count
    share_with_laws: Share
    longest_window: Annotated[float, above(0.0), at_most(0.5)]
    look: Positive
    fine_look: Positive
    log_look: Positive
    stillness: Stillness
    poor: Positive
    least_size: Positive
    seed: Natural

    def __post_init__(self) -> None:
        require_bounds(self, "next_experiment")
        if not self.durations or not all(duration > 0 for duration in self.durations):
            raise ConfigError("next_experiment.durations needs a length above 0 s.")
        if not self.scales or not all(0 < scale <= 1 for scale in self.scales):
            raise ConfigError("next_experiment.scales needs shares above 0, up to 1.")
