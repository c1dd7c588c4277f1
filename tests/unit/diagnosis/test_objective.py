"""How much of a cost is worth a step, and slopes that follow a step."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import pendulum, solver_settings, swinging, windows_of

from dr_lab.diagnosis.fit.correlation import colour
from dr_lab.diagnosis.fit.objective import Objective
from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.slopes import Slopes
from dr_lab.trajectory import Array

WINDOWS, STATES, PARAMETERS, SAMPLES = 6, 2, 3, 40
TOLERANCE = 0.05


def random_slopes(seed: int) -> Slopes:
    rng = np.random.default_rng(seed)
    sizes = 10.0 ** rng.uniform(-3, 3, STATES + PARAMETERS)  # units of all sizes
    whole = rng.standard_normal((WINDOWS, SAMPLES, STATES + PARAMETERS)) * sizes
    return Slopes(whole[..., :STATES], whole[..., STATES:])


def change_by(slopes: Slopes, state_move: Array, move: Array) -> Array:
    return (slopes.state @ state_move[..., None])[..., 0] + slopes.parameter @ move


def test_slopes_that_followed_a_step_foretell_it_and_remember_the_rest() -> None:
    rng, slopes = np.random.default_rng(0), random_slopes(1)
    state_move, move = rng.standard_normal((WINDOWS, STATES)), rng.standard_normal(PARAMETERS)
    change = rng.standard_normal((WINDOWS, SAMPLES))
    found = slopes.secant(change, state_move, move)
    np.testing.assert_allclose(change_by(found, state_move, move), change, atol=1e-9)
    weights = [(part**2).sum(1) for part in (slopes.state, slopes.parameter)]  # D², by which directions are across
    across = np.array([weights[0][:, 1] * state_move[:, 1], -weights[0][:, 0] * state_move[:, 0]]).T
    still = np.zeros(PARAMETERS)
    np.testing.assert_allclose(change_by(found, across, still), change_by(slopes, across, still), rtol=1e-6)


def test_slopes_that_foretold_a_step_stay_as_they_are() -> None:
    rng, slopes = np.random.default_rng(2), random_slopes(3)
    state_move, move = rng.standard_normal((WINDOWS, STATES)), rng.standard_normal(PARAMETERS)
    for given in (change_by(slopes, state_move, move), np.ones((WINDOWS, SAMPLES))):
        still = given.max() == 1.0
        steps = (np.zeros_like(state_move), np.zeros_like(move)) if still else (state_move, move)
        found = slopes.secant(given, *steps)
        np.testing.assert_allclose(found.state, slopes.state, rtol=1e-9)
        np.testing.assert_allclose(found.parameter, slopes.parameter, rtol=1e-9)


def test_residuals_that_are_alike_in_threes_tell_a_third() -> None:
    rng = np.random.default_rng(4)
    white = rng.standard_normal((200, 100, 2))
    threes = np.repeat(rng.standard_normal((200, 100, 1)), 3, axis=1)
    parts = [(rows, np.ones(rows.shape, bool)) for rows in (white, threes)]
    assert colour(parts[:1]) == pytest.approx(1.0, abs=0.05)
    assert colour(parts[1:]) == pytest.approx(3.0, rel=0.1)
    assert colour(parts) == pytest.approx((40_000 + 60_000) / (40_000 + 20_000), rel=0.1)
    assert colour([]) == 1.0


@pytest.fixture(scope="module")
def replay() -> Replay:
    model = pendulum()
    return Replay(model, windows_of(model, [swinging("log", model.compile(model.space.nominal), 0, seconds=6.0)]), 1)


def residuals_of(replay: Replay, size: float, alike: int) -> Point:
    shape = replay.fitted.shape
    drawn = np.random.default_rng(5).standard_normal((shape[0], -(-shape[1] // alike)))
    rows = size * np.repeat(drawn, alike, axis=1)[:, : shape[1]] * replay.fitted
    delta = np.zeros((shape[0], replay.nstate))
    point = Point(replay.model.space.nominal, delta, rows, np.inf, np.zeros(shape[0], bool))
    return replace(point, cost=float((rows**2).sum()))


@pytest.mark.parametrize(("size", "alike", "times"), [(1, 1, 1), (0.1, 5, 1), (4, 1, 16), (1, 5, 5), (4, 5, 80)])
def test_larger_and_more_alike_errors_need_fewer_steps(replay: Replay, size: float, alike: int, times: float) -> None:
    objective, point = Objective(replay, solver_settings()), residuals_of(replay, size, alike)
    least = objective.negligible(point, TOLERANCE)
    assert least == pytest.approx(times * TOLERANCE, rel=0.25)
    n = replay.fitted.sum() / alike
    if size > 1:
        assert n * np.log(point.cost / (point.cost - least)) == pytest.approx(TOLERANCE, rel=0.25)
    assert objective.rough(point) == 3e-3 * max(point.cost, replay.fitted.sum())
