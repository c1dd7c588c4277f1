from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from diagnosis_machines import (
    NOISE,
    clock,
    log_of,
    model_of,
    pendulum,
    predicted_settings,
    solver_settings,
    swinging,
    windows_of,
    windows_settings,
)
from scipy.spatial.transform import Rotation

from dr_lab.diagnosis.evidence.score import score_of, taken_by_states
from dr_lab.diagnosis.fit.point import Mask
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import StateFit, fit_states
from dr_lab.trajectory import Array, Log

FREE = """<mujoco model="free">
  <worldbody><body name="b"><joint name="ball" type="ball"/><geom size="0.1"/></body></worldbody>
  <sensor><framequat name="pose" objtype="body" objname="b"/></sensor>
</mujoco>"""


def pendulum_replay() -> Replay:
    model = pendulum()
    return Replay(model, windows_of(model, [swinging("a", model.nominal(), 0)]), 1)


def point(replay: Replay, residuals: Array, infeasible: Mask | None = None) -> StateFit:
    mask: Mask = np.zeros(len(residuals), np.bool_) if infeasible is None else infeasible
    slopes = np.zeros((*residuals.shape, replay.nstate))
    return StateFit(np.zeros(2), np.zeros((len(residuals), replay.nstate)), residuals, 0.0, mask, slopes)


def test_errors_are_mean_squares_in_the_signals_unit() -> None:
    replay = pendulum_replay()
    score = score_of(replay, point(replay, np.full(replay.scored.shape, 3.0)))
    assert score.chi2 == pytest.approx(9.0)
    assert score.rmse["hinge.position"] == pytest.approx(3 * NOISE)
    (samples,) = replay.windows.samples
    spread = np.std(samples.value[samples.scored])
    assert score.nrmse["hinge.position"] == pytest.approx(3 * NOISE / spread)
    assert score.fit_percent["hinge.position"] == pytest.approx(100 * (1 - 3 * NOISE / spread))
    np.testing.assert_allclose(score.window_sum, 9.0 * score.window_count)


def test_windows_that_diverge_count_for_nothing() -> None:
    replay = pendulum_replay()
    lost = np.arange(len(replay.windows)) < 3
    residuals = np.where(lost[:, None], 1e9, np.ones(replay.scored.shape))
    score = score_of(replay, point(replay, residuals, lost))
    assert score.chi2 == pytest.approx(1.0)
    assert score.rmse["hinge.position"] == pytest.approx(NOISE)
    assert score.infeasible == 3
    assert not score.window_sum[:3].any()
    assert not score.window_count[:3].any()


def test_nothing_that_simulates_is_not_the_noise_floor() -> None:
    replay = pendulum_replay()
    every = np.ones(len(replay.windows), bool)
    score = score_of(replay, point(replay, np.zeros(replay.scored.shape), every))
    assert score.chi2 == np.inf
    assert np.isnan(score.rmse["hinge.position"])  # 0 would be the best of all


def sparse(seed: int) -> Log:
    """Ten samples a window."""
    log = swinging(f"log {seed}", pendulum().nominal(), seed, seconds=12.0)
    (signal,) = log.outputs.values()
    thinned = replace(signal, time=signal.time[::15], value=signal.value[::15])
    return replace(log, outputs={signal.name: thinned})


@pytest.mark.slow
def test_the_noise_floor_is_one_however_few_samples_a_window_has() -> None:
    model = pendulum()
    windows = windows_of(model, [sparse(k) for k in range(6)], windows_settings(seconds=1000.0, smoother=0.1))
    score = score_of(*fit_states(model, model.space.nominal, windows, solver_settings(), 1))
    assert score.window_count == pytest.approx(8.0, abs=0.3)  # two states a window
    assert score.chi2 == pytest.approx(1.0, abs=3 * np.sqrt(2 / score.window_count.sum()))


def test_a_start_from_earlier_samples_takes_none_of_the_scored_ones() -> None:
    model = pendulum()
    windows = windows_of(model, [swinging("a", model.nominal(), 0)], predicted_settings())
    replay, states = fit_states(model, model.space.nominal, windows, solver_settings(), 1)
    np.testing.assert_array_equal(score_of(replay, states).window_count, replay.scored.sum(1))


def test_orientations_spread_as_angles() -> None:
    time = clock(1000)
    turn = Rotation.from_rotvec(np.outer(np.sin(20 * time), [0.0, 0.4, 0.0]))
    sign = np.where(np.arange(len(time)) % 3, 1.0, -1.0)[:, None]  # q and −q are one orientation
    log = log_of("a", {"sensor.pose": (time, sign * turn.as_quat(scalar_first=True))})
    model = model_of(FREE)
    replay = Replay(model, windows_of(model, [log]), 1)
    (samples,) = replay.windows.samples
    score = score_of(replay, point(replay, np.full(replay.scored.shape, 5.0)))
    angle = 0.4 * np.sin(20 * (samples.time + replay.windows.begin[:, None]))[samples.scored]
    # the noise is that of a quaternion's components, half an angle; three components of 5 σ each
    assert score.rmse["sensor.pose"] == pytest.approx(5 * 2 * NOISE)
    assert score.nrmse["sensor.pose"] == pytest.approx(np.sqrt(3) * 5 * 2 * NOISE / np.std(angle), rel=1e-3)


@pytest.mark.parametrize("spread", [0.05, 1.0, 1e3])
def test_unknowns_take_what_their_prior_lets_them_take(spread: float) -> None:
    """The ridge estimate leaves (1 − A) C (1 − A)ᵀ, C of noise and unknowns that scatter as their prior says."""
    slopes = np.random.default_rng(0).standard_normal((1, 30, 4))
    used, std = np.ones((1, 30), bool), np.full(4, spread)
    replay = cast(Any, SimpleNamespace(fitted=used, windows=SimpleNamespace(prior=SimpleNamespace(std=std))))
    taken = taken_by_states(replay, cast(Any, SimpleNamespace(slopes=slopes)), used)
    left = np.eye(30) - slopes[0] @ np.linalg.solve(slopes[0].T @ slopes[0] + np.diag(std**-2.0), slopes[0].T)
    before = np.eye(30) + slopes[0] @ np.diag(std**2) @ slopes[0].T  # noise, and unknowns that scatter as the prior
    np.testing.assert_allclose(taken[0], 1 - np.diag(left @ before @ left.T), atol=1e-9)
    if spread == 1e3:
        assert taken.sum() == pytest.approx(4.0, rel=1e-5)  # free unknowns take one residual each
