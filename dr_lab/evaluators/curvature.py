"""How sharply a policy's return bends where training has led: eigenvalues of a Hessian, and the return along them."""

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import torch
from torch import Tensor

from dr_lab.algorithms.reinforce.baseline import Baseline
from dr_lab.algorithms.reinforce.score_function import gains
from dr_lab.bounds import Bound, Count, Positive, at_least, at_most
from dr_lab.errors import DataError
from dr_lab.evaluators.evaluator import Evaluation, Progress, Row, Subject
from dr_lab.evaluators.interval_evaluator import IntervalEvaluator
from dr_lab.evaluators.policy_gradients import PlayedEpisodes, played, require_gaussian, spread_over
from dr_lab.evaluators.statistics import mean_interval
from dr_lab.files import write_text
from dr_lab.networks.flat import parts_of
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.spectrum import curvatures, ends_of_spectrum, hessian_product
from dr_lab.recorders.training import ContextAxis, Grid
from dr_lab.reports.csv_rows import rows_csv
from dr_lab.seeding import derived_seed, stream
from dr_lab.trajectory import Array

_ODD = Bound(lambda value: value % 2 == 1, "an odd number")
_ENDS = {"largest": 0, "smallest": -1}  # eigenvalues, descending


@dataclass(frozen=True, kw_only=True)
class CurvatureEvaluator(IntervalEvaluator):
    """Both ends of the spectrum of ∇²L, L = −(1/k) Σ_i Σ_t ρ_t A_t the surrogate loss, as training went on.

    At a maximum of the return no eigenvalue is below 0, at a saddle some are. Noise makes the largest eigenvalue of few
    episodes too large and the smallest too small; so eigenvectors are found on half of the episodes, and the curvature
    along them is measured on the others. Along the two outermost ones the last policy is moved and played again.

    Source: Mehta 2020 (thesis), §3.3, which looks at the return of perturbed policies; `gains` says how L bends unlike
    the return.

    Attributes: as `IntervalEvaluator`, its episodes in each half, one in each context that was trained on, and
        eigenvalues: at each end of the spectrum.
        snapshots: policies at most, of those that the run kept, at equal distances.
        reach: largest distance that a policy is moved, length of all its parameters.
        steps: distances at which it is played, an odd number, so that 0 is among them.
        parallel: episodes side by side.
        baseline: what is taken off the returns-to-go.
        gamma: discount per control step.

    Raises:
        ConfigError: a number is out of its range.
    """

    eigenvalues: Count
    snapshots: Count
    reach: Positive
    steps: Annotated[int, at_least(3), _ODD]
    episodes: Annotated[int, at_least(2)]
    parallel: Count
    baseline: Baseline
    gamma: Annotated[float, at_least(0.0), at_most(1.0)]

    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Find the ends of the spectrum for each snapshot, and play along those of the last; writes ``along.csv``.

        Raises:
            ConfigError: the policy is not Gaussian.
            DataError: the run has kept no policy, or hardly an episode is feasible.
        """
        chosen = spread_over(subject.kept(), self.snapshots)
        actors = [require_gaussian(each.exploring, "curvature") for each in chosen]
        rows, vectors, measured = list[Row](), np.empty((0, 0)), list[int]()
        for number, (snapshot, actor) in enumerate(zip(chosen, actors, strict=True), start=1):
            values, vectors = self._spectrum(actor, self._played(subject, actor, "found"))
            other = self._played(subject, actor, "measured")
            measured.append(len(other.returns))
            rows += [self._row(snapshot.frames, actor, other, *each) for each in zip(values, vectors, strict=True)]
            progress(number / (len(chosen) + 1))
        along = {name: vectors[place] for name, place in _ENDS.items()}
        grids = self._along(subject, actors[-1], along, folder)
        progress(1.0)
        return Evaluation(_figures(rows[-len(vectors) :]), rows, grids=grids, told=self._told(measured))

    def _along(self, subject: Subject, actor: GaussianActor, along: Mapping[str, Array], folder: Path) -> list[Grid]:
        """Move a policy along some directions and play it; the table is a file of its own."""
        course, moved = self._played(subject, actor, "measured"), dict[str, list[dict[str, float]]]()
        for name, direction in along.items():
            moved[name] = [self._moved(subject, actor, course, direction, distance) for distance in self._distances]
        table = [{"along": f"{name} eigenvalue", **row} for name, rows in moved.items() for row in rows]
        write_text(folder / "along.csv", rows_csv(table))
        return [self._picture(name, rows) for name, rows in moved.items()]

    @property
    def _distances(self) -> Array:
        return np.linspace(-self.reach, self.reach, self.steps)

    def _played(self, subject: Subject, actor: GaussianActor, half: str) -> PlayedEpisodes:
        """Episodes in contexts that were trained on; the same ones, with the same noise, whatever the policy."""
        seed = derived_seed(self.seed, "curvature", half)
        actor.reseed(seed)
        z = subject.contexts(self.episodes, stream(seed, "contexts"))
        course = played(subject.slots(self.parallel, seed), actor, z, self.baseline, self.gamma)
        if len(course.advantage) < 2:
            raise DataError(
                f"Of {self.episodes} episodes of run {subject.name} {len(course.advantage)} are feasible; expected two "
                "at least. Give run=FOLDER of one on other contexts."
            )
        return course

    def _spectrum(self, actor: GaussianActor, course: PlayedEpisodes) -> tuple[Array, Array]:
        losses, at = _losses(actor, course)
        product = hessian_product(lambda vector: losses(vector).mean(), at)
        return ends_of_spectrum(product, len(at), self.eigenvalues, self.seed)

    def _row(self, frames: int, actor: GaussianActor, course: PlayedEpisodes, eigenvalue: float, along: Array) -> Row:
        losses, at = _losses(actor, course)
        measured = mean_interval(curvatures(losses, at, along), self.confidence, self.resamples, self.seed)
        return {
            "frames": float(frames),
            "eigenvalue": float(eigenvalue),
            "curvature": measured.value,
            "low": measured.low,
            "high": measured.high,
        }

    def _moved(
        self, subject: Subject, actor: GaussianActor, course: PlayedEpisodes, along: Array, distance: float
    ) -> dict[str, float]:
        """What the policy returns when it is moved, discounted, and what the surrogate says of it."""
        losses, at = _losses(actor, course)
        vector = at + distance * torch.from_numpy(along)
        moved = copy.deepcopy(actor)
        with torch.no_grad():
            for name, value in parts_of(vector, dict(moved.named_parameters())).items():
                moved.get_parameter(name).copy_(value)
            surrogate = course.returns.mean() - losses(vector).mean()
        returns = self._played(subject, moved, "measured").returns
        return {
            "distance": float(distance),
            "return": float(returns.mean()),
            "std": float(returns.std(correction=0)),
            "surrogate": float(surrogate),
        }

    def _picture(self, name: str, course: Sequence[Mapping[str, float]]) -> Grid:
        axis = ContextAxis(f"distance along the eigenvector of the {name} eigenvalue", "", self._distances)
        value, spread = (np.array([row[key] for row in course]) for key in ("return", "std"))
        return Grid(f"{name} eigenvalue", [axis], value, spread, "episodes")

    def _told(self, measured: Sequence[int]) -> str:
        return (
            "Eigenvalues of the Hessian of the surrogate loss, the discounted return with its sign turned, by all "
            f"parameters of the exploring policy, from {self.episodes} episodes in contexts that were trained on: the "
            "largest and the smallest. Above 0 the return falls to both sides of the policy, below 0 it rises. "
            "curvature: along the same eigenvectors on as many other episodes, with its "
            f"interval ({self.stated(*measured)}); of the two it is the one without bias. In along.csv and the "
            "pictures the last policy is moved along the two outermost eigenvectors: its discounted return when it is "
            "played and, in the former, what the surrogate says of it."
        )


def _figures(rows: Sequence[Row]) -> dict[str, float]:
    """Of the outermost eigenvalues among those of one policy, descending."""
    shown = ("eigenvalue", "curvature", "low", "high")
    return {f"{name}.{key}": float(rows[place][key]) for name, place in _ENDS.items() for key in shown}


def _losses(actor: GaussianActor, course: PlayedEpisodes) -> tuple[Callable[[Tensor], Tensor], Tensor]:
    """Loss of each episode as a function of all parameters (p,), 0 at the policy's own, which come second."""
    parameters = {name: value.detach().double() for name, value in actor.named_parameters()}

    def losses(vector: Tensor) -> Tensor:
        return -gains(parts_of(vector, parameters), actor, course.episodes, course.advantage)

    return losses, torch.cat([value.flatten() for value in parameters.values()])
