"""Fits that are asked for a cost, and end where they would not reach it."""

import numpy as np
import pytest
from diagnosis_machines import pendulum, solver_settings, swinging, windows_of

from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay

TRUTH = np.array([0.6, 0.08])


def replay() -> Replay:
    model = pendulum()
    return Replay(model, windows_of(model, [swinging("log_0", model.compile(TRUTH), 0, seconds=3.0)]), 1)


def test_a_fit_that_cannot_reach_its_goal_ends() -> None:
    fitter = Fitter(replay(), solver_settings())
    nominal = fitter.space.nominal
    whole = fitter.run(nominal)
    early, late = (fitter.run(nominal, goal=share * whole.cost) for share in (0.5, 2.0))
    assert not early.converged
    assert early.cost > 0.5 * whole.cost
    assert late.converged
    assert late.cost == pytest.approx(whole.cost)


@pytest.mark.parametrize(("iterations", "late"), [(15, True), (60, False)])
def test_a_fit_that_at_its_pace_would_not_reach_its_goal_in_time_ends(iterations: int, *, late: bool) -> None:
    """Damping that never falls keeps the steps short, whatever a full step foretells: some 6 % of the cost each."""
    slow = solver_settings(iterations=iterations, damping=30.0, damping_down=1.0, crawl=5, restarts=0)
    fitter = Fitter(replay(), slow)
    nominal = fitter.space.nominal
    goal = 0.1 * fitter.run(nominal, iterations=0).cost
    found = fitter.run(nominal, goal=goal)
    assert found.late == late
    assert (found.iterations < iterations) == late
    assert (found.cost > goal) == late


@pytest.mark.parametrize("share", [0.5, 2.0])
def test_a_fit_begins_at_a_start_only_where_its_states_let_it_fit_well_enough(share: float) -> None:
    fitter, wrong = Fitter(replay(), solver_settings()), 2.0 * TRUTH
    there = fitter.run(wrong, iterations=0)
    start = fitter.begin(TRUTH, there.delta)
    least = fitter.rerun(start, goal=-np.inf).cost  # a goal that no step reaches: it ends at once
    found = fitter.rerun_below(start, there, least / share, goal=-np.inf)
    assert found.iterations == 0
    assert found.z == pytest.approx(TRUTH if share < 1 else wrong)
