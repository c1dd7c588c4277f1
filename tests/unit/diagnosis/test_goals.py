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


def test_a_rough_fit_takes_a_step_before_it_is_given_up() -> None:
    """Of a long lag the slope at absent foretells too little; one step more shows what there is."""
    nominal = replay().model.space.nominal
    taken = [
        Fitter(replay(), solver_settings(), rough=rough).run(nominal, goal=-np.inf).iterations
        for rough in (False, True)
    ]
    assert taken == [0, 1]


@pytest.mark.slow
def test_a_bound_that_may_be_moved_does_not_foretell_the_end() -> None:
    """The truth's damping lies at twice its upper bound: a fit stops there, and is wanted all the same."""
    model = pendulum()
    beyond = np.array([0.6, 2.0 * model.space.high[1]])
    windows = windows_of(model, [swinging("log_0", model.compile(beyond), 0, seconds=3.0)])
    fitters = [
        Fitter(Replay(model, windows, 1), solver_settings(), reach=(np.zeros(1), np.array([far]))) for far in (0.0, 2.0)
    ]
    at_bound = fitters[0].run(model.space.nominal)
    held, moved = (fitter.run(model.space.nominal, goal=0.3 * at_bound.cost) for fitter in fitters)
    assert not held.converged
    assert moved.converged
    assert moved.z[1] == model.space.high[1]


@pytest.mark.parametrize(("iterations", "late"), [(15, True), pytest.param(60, False, marks=pytest.mark.slow)])
def test_a_fit_that_at_its_pace_would_not_reach_its_goal_in_time_ends(iterations: int, *, late: bool) -> None:
    """Damping that never falls keeps the steps short, whatever a full step foretells: some 6 % of the cost each."""
    slow = solver_settings(iterations=iterations, damping=30.0, damping_down=1.0, pace=5, restarts=0)
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
