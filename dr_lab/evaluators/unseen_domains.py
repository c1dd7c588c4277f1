"""Returns in domains that training has not seen, beside those in the domains that it has."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dr_lab.bounds import Count, require_bounds
from dr_lab.envs.batched_env import single
from dr_lab.evaluators.deployment import inference_seconds, parameter_bytes
from dr_lab.evaluators.evaluator import Evaluation, Evaluator, Progress, Row, Subject, Table
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.recorders.training import Sample
from dr_lab.seeding import stream
from dr_lab.trajectory import Array

UNSEEN, TEACHERS = "unseen", "teachers"
_FEW = 4  # parameters, for which a page has room


@dataclass(frozen=True, kw_only=True)
class UnseenDomainsEvaluator(Evaluator):
    """Episodes from several starts in each of many drawn domains.

    Domains hang on the seed alone, starts on the seed and on `parallel`: each slot draws its own. So they are the same
    for every policy that was trained on the same distribution and is played with the same of both.

    A policy that was trained on a few domains has not seen those that are drawn anew. It plays its own
    (`Algorithm.domains`, its teachers'), too. One that was trained on all of their distribution has seen their like;
    `distribution` takes it elsewhere.

    Source: Brosseit et al. 2021, Distilled Domain Randomization, §V, figures 3 and 4 (32 domains, 100 starts).

    Attributes:
        distribution: makes what domains are drawn from, over the model's parameters; None for what was trained on.
        domains: drawn from it.
        starts: episodes in each domain.
        parallel: episodes side by side; another number draws other starts.
        calls: of the policy, whose median time is told.
        seed: of domains and starts.

    Raises:
        ConfigError: a number is out of its range.
    """

    distribution: Callable[[ContextSpace], Randomizer] | None
    domains: Count
    starts: Count
    parallel: Count
    calls: Count
    seed: int

    def __post_init__(self) -> None:
        require_bounds(self, "evaluator")

    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Play all; a summary says what the domains are like and how the policy does in each, the worst first."""
        del folder
        kinds = {UNSEEN: self._unseen(subject)}
        if subject.domains is not None:
            kinds[TEACHERS] = subject.domains
        played: dict[str, Array] = {}
        figures: dict[str, float] = {}
        rows: list[Row] = []
        table: list[Row] = []
        for place, (kind, z) in enumerate(kinds.items(), start=1):
            rollouts = subject.rollouts(self.parallel, self.seed)
            played[kind], infeasible = rollouts.outcomes(np.repeat(z, self.starts, axis=0))
            returns = played[kind].reshape(len(z), self.starts)
            figures |= {f"{kind}.{key}": value for key, value in _quartiles(returns).items()}
            figures[f"{kind}.infeasible"] = float(infeasible.mean())
            rows += list(_rows(kind, returns))
            table += list(_table(kind, subject.setting.space, z, returns))
            progress(place / len(kinds))
        figures |= self._cost(subject)
        samples = [Sample(kind, returns, "An episode each.") for kind, returns in played.items()]
        rows.sort(key=lambda row: float(row["return"]))
        table.sort(key=lambda row: float(row["median"]))
        units = {parameter.name: parameter.unit for parameter in subject.setting.space.parameters}
        shown = [name for name in table[0] if len(units) <= _FEW or name not in units]
        summary, told = Table("domains.csv", table, shown), self._told(len(kinds) > 1)
        return Evaluation(figures, rows, units, samples=samples, summary=summary, told=told)

    def _unseen(self, subject: Subject) -> Array:
        """Domains, shape (domains, n)."""
        rng = stream(self.seed, "unseen_domains")
        if self.distribution is None:
            return subject.contexts(self.domains, rng)
        return self.distribution(subject.setting.space).sample([rng] * self.domains)

    def _cost(self, subject: Subject) -> dict[str, float]:
        """Of an action, s and bytes."""
        observation = single(subject.slots(1, self.seed).observation)
        seconds = inference_seconds(subject.policy, observation, self.calls)
        return {"inference_seconds": seconds, "parameter_bytes": parameter_bytes(subject.policy)}

    def _told(self, taught: bool) -> str:
        drawn = "from a distribution of their own" if self.distribution else "anew from what the policy was trained on"
        told = (
            f"{self.domains} domains, drawn {drawn}, {self.starts} episodes in each, from starts that are "
            f"the same for every policy that is played with evaluator.seed={self.seed} and "
            f"evaluator.parallel={self.parallel}. median, lower and upper quartile: over all of these episodes. "
            "infeasible: share of them that diverge, which count with the return that the task declares. inference "
            f"seconds: median time of an action for one observation over {self.calls} calls on one core. parameter "
            "bytes: memory of the policy's parameters. The table begins with the domain of the lowest median; "
            "domains.csv says what each is like, returns.csv holds every episode."
        )
        return f"{told} teachers: the domains that the policy was trained on." if taught else told


def _quartiles(returns: Array) -> dict[str, float]:
    first, median, third = np.quantile(returns, [0.25, 0.5, 0.75]).tolist()
    return {"median": median, "lower_quartile": first, "upper_quartile": third}


def _rows(kind: str, returns: Array) -> Iterator[Row]:
    for (domain, start), value in np.ndenumerate(returns):
        yield {"domains": kind, "domain": float(domain), "start": float(start), "return": float(value)}


def _table(kind: str, space: ContextSpace, z: Array, returns: Array) -> Iterator[Row]:
    for domain, (values, each) in enumerate(zip(z, returns, strict=True)):
        yield {"domains": kind, "domain": float(domain), **_quartiles(each), **space.mapping(values)}
