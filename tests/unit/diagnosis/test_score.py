import numpy as np
import pytest
from diagnosis_machines import NOISE, clock, log_of, model_of, pendulum, swinging, windows_of
from scipy.spatial.transform import Rotation

from dr_lab.diagnosis.point import Mask, Point
from dr_lab.diagnosis.replay import Replay
from dr_lab.diagnosis.score import score_of
from dr_lab.trajectory import Array

FREE = """<mujoco model="free">
  <worldbody><body name="b"><joint name="ball" type="ball"/><geom size="0.1"/></body></worldbody>
  <sensor><framequat name="pose" objtype="body" objname="b"/></sensor>
</mujoco>"""


def pendulum_replay() -> Replay:
    model = pendulum()
    return Replay(model, windows_of(model, [swinging("a", model.nominal(), 0)]), 1)


def point(replay: Replay, residuals: Array, infeasible: Mask | None = None) -> Point:
    mask: Mask = np.zeros(len(residuals), np.bool_) if infeasible is None else infeasible
    return Point(np.zeros(2), np.zeros((len(residuals), replay.nstate)), residuals, 0.0, mask)


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
    assert score_of(replay, point(replay, np.zeros(replay.scored.shape), every)).chi2 == np.inf


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
