"""What lower costs promise, as evidence of residuals of which some are independent."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from diagnosis_machines import evidence_settings, pendulum, solver_settings, swinging, windows_of

from dr_lab.diagnosis.evidence.bench import Bench, beyond_doubt, fit_and_score
from dr_lab.diagnosis.fit.fit import Fit

WINDOWS = windows_of(pendulum(), [swinging("a", pendulum().nominal(), 0)])
BENCH = Bench(WINDOWS, WINDOWS, solver_settings(), evidence_settings(), threads=1)
COUNT = len(WINDOWS)


def base(level: float) -> Fit:
    """A fit that leaves this χ²."""
    lost = np.zeros(COUNT, bool)
    return cast(Fit, SimpleNamespace(cost=level * BENCH.samples, delta=np.zeros((COUNT, 2)), infeasible=lost))


def test_far_above_white_noise_a_share_promises_its_logarithm() -> None:
    found = BENCH.promise(0.3 * base(100.0).cost, base(100.0))
    assert found == pytest.approx(-BENCH.samples * np.log(0.7))
    assert BENCH.promise(0.3 * base(100.0).cost, base(100.0), 3) == pytest.approx(found - 3 * BENCH.evidence.penalty)


def test_what_stays_coloured_promises_less_and_what_becomes_white_does_not() -> None:
    coloured, fit = replace(BENCH, colour=50.0), base(1e6)
    little, all_of_it = 0.01 * fit.cost, (1 - 1e-6) * fit.cost
    assert coloured.promise(little, fit) == pytest.approx(BENCH.promise(little, fit) / 49.51)
    assert coloured.promise(all_of_it, fit) == pytest.approx(BENCH.promise(all_of_it, fit), rel=1e-3)


@pytest.mark.parametrize("level", [1.05, 2.0, 1e4])
@pytest.mark.parametrize("colour", [1.0, 30.0])
def test_the_cost_that_is_hoped_for_promises_just_that(level: float, colour: float) -> None:
    bench, fit = replace(BENCH, colour=colour), base(level)
    gain = fit.cost - bench.hoped(fit)
    assert 0 < gain < fit.cost
    assert bench.promise(gain, fit) == pytest.approx(bench.hope)


def test_no_cost_is_hoped_for_where_windows_diverge() -> None:
    lost = replace(BENCH, colour=2.0)
    fit = cast(Fit, SimpleNamespace(**{**vars(base(2.0)), "infeasible": np.arange(COUNT) == 1}))
    assert np.isinf(lost.hoped(fit))


def test_coloured_residuals_leave_more_room_for_doubt() -> None:
    model = pendulum()
    found = fit_and_score(BENCH, model, model.space.nominal)
    doubt = beyond_doubt(BENCH, found)
    enough = BENCH.evidence.enough_hope * BENCH.evidence.threshold
    assert doubt == pytest.approx(found.fit.cost * np.exp(enough * found.held_out.colour / BENCH.samples))
