"""Settings of the next experiment; their values live in conf/next_experiment."""

from collections.abc import Sequence
from dataclasses import dataclass

from dr_lab.bounds import Count, Natural, Positive, require_bounds
from dr_lab.diagnosis.next_experiment.family import Multisines
from dr_lab.diagnosis.next_experiment.limits import Safety
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
        sizings: tries to find the largest size of each experiment that keeps the limits.
        elite: the best experiments, of which the next generation is made.
        simulations: of a generation's experiments in rough refits or linear steps; where these are too few for all,
            those that promise most and others at random share them.
        seconds: s of each experiment on which that is done.
        iterations: steps of a rough refit.
        refitted: the best experiments that are judged by refits in the end.
        poor: share of a parameter's size from which on its standard deviation makes it poorly known.
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
    sizings: Count
    elite: Count
    simulations: Count
    seconds: Positive
    iterations: Count
    refitted: Count
    poor: Positive
    seed: Natural

    def __post_init__(self) -> None:
        require_bounds(self, "next_experiment")
        if not self.durations or not all(duration > 0 for duration in self.durations):
            raise ConfigError("next_experiment.durations needs a length above 0 s.")
