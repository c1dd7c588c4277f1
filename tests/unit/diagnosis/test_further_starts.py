"""Which start away from absent a fit goes on from, by its pace."""

from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
import pytest
from refit_machines import effect_of, fits_of, rubbing

from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.search.candidate_fits import CandidateFits
from dr_lab.trajectory import Array


@dataclass
class Foreseen:
    """A fitter of which it is known how the costs fall: from absent, and from a further start."""

    fit: Fit
    absent: tuple[float, ...]
    start: tuple[float, ...]

    def go_on(self, there: Fit, goal: float) -> Fit:
        del there, goal
        return replace(self.fit, cost=self.absent[-1], costs=self.absent)

    def begin(self, z: Array, delta: Array) -> Fit:
        return replace(self.fit, z=z, delta=delta)

    def run(
        self, z: Array, delta: Array, known: object = None, iterations: int | None = None, goal: float = np.inf
    ) -> Fit:
        del known, goal
        costs = self.start if iterations is None else self.start[: iterations + 1]
        return replace(self.fit, z=z, delta=delta, cost=costs[-1], costs=costs)


@pytest.mark.parametrize(
    ("start", "noise", "best"),
    [
        pytest.param((90.0, 50.0, 40.0, 30.0, 19.0, 5.0, 1.0), False, 1.0, id="as fast as from absent"),
        pytest.param((90.0, 50.0, 40.0, 30.0, 21.0, 5.0, 1.0), False, 9.0, id="slower"),
        pytest.param((90.0, 50.0, 40.0, 30.0, 19.0, 18.0, 17.0), False, 9.0, id="as fast at first, and stuck"),
        pytest.param((90.0, 50.0, 40.0, 30.0, 19.0, 5.0, 1.0), True, 9.0, id="nothing is left to gain"),
    ],
)
def test_a_start_is_gone_on_with_that_is_as_low_as_the_fit_from_absent_was_after_as_many_steps(
    start: tuple[float, ...], best: float, monkeypatch: pytest.MonkeyPatch, *, noise: bool
) -> None:
    """That fit is at 20 after four steps and ends at 9; what a start must be below is not that end."""
    fits, effect = fits_of(rubbing), effect_of("coulomb_friction")
    assert fits.bench.solver.start_iterations == 4
    first = fits.look(effect)
    first = replace(first, starts=(first.best,))
    monkeypatch.setattr(CandidateFits, "_leaves_noise", lambda *_: noise)
    fitter = Foreseen(first.absent, (100.0, 80.0, 60.0, 40.0, 20.0, 10.0, 9.0), start)
    assert fits._of_starts(cast(Any, fitter), effect, first, np.inf, first.absent).cost == best
