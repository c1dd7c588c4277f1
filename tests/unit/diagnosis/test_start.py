from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import NOISE, clock, measured, model_of, pendulum, predicted_settings, windows_settings

from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.start_prior import StartPrior
from dr_lab.diagnosis.windows.windows import Windows, cut
from dr_lab.trajectory import Array, Log, Signal

TIME = np.sort(np.random.default_rng(0).uniform(0.0, 4.0, 2000))
CARTPOLE = """<mujoco model="cartpole"><compiler angle="radian"/><worldbody><body name="cart">
  <joint name="rail" type="slide" axis="1 0 0"/><geom size="0.1"/>
  <body name="pole"><joint name="hinge" axis="0 1 0" ref="0.2"/><geom size="0.1" pos="0 0 1"/></body>
</body></worldbody></mujoco>"""


def log(**channels: Array) -> Log:
    names = {name: name.replace("_", ".") for name in channels}
    return Log("a", {names[n]: Signal(names[n], "", TIME, value) for n, value in channels.items()}, {})


def windows(one: Log, settings: WindowSettings, xml: str | None = None) -> Windows:
    model = model_of(xml) if xml else pendulum()
    return cut([one], measured([one]), model.nominal(), settings)


@pytest.mark.parametrize("settings", [windows_settings(), predicted_settings()])
def test_polynomial_motion_gives_exact_starts(settings: WindowSettings) -> None:
    cubic = np.polynomial.Polynomial([0.3, -1.0, 2.0, -0.4])
    found = windows(log(hinge_position=cubic(TIME)), settings)
    np.testing.assert_allclose(found.prior.qpos[:, 0], cubic(found.begin), atol=1e-9)
    np.testing.assert_allclose(found.prior.qvel[:, 0], cubic.deriv()(found.begin), atol=1e-7)
    np.testing.assert_allclose(found.prior.qacc[:, 0], cubic.deriv(2)(found.begin), atol=1e-4)
    expected = settings.prior_scale * NOISE
    np.testing.assert_allclose(found.prior.std, [expected, expected / settings.smoother])


def test_what_a_polynomial_misses_widens_the_prior() -> None:
    gentle, wild = (windows(log(hinge_position=np.sin(w * TIME)), windows_settings()).prior for w in (1.0, 60.0))
    assert wild.std[0] > 10 * gentle.std[0]
    assert wild.std[1] > 10 * gentle.std[1]


@pytest.mark.parametrize("rate", [25.0, 50.0, 100.0, 500.0])
def test_starts_are_as_well_known_as_the_prior_says_whatever_the_rate(rate: float) -> None:
    speed, settings = 12.0, windows_settings(seconds=20.0)
    time = np.arange(0.0, 20.0, 1 / rate)
    one = Log("a", {"hinge.position": Signal("hinge.position", "", time, np.sin(speed * time))}, {})
    found = windows(one, settings)
    missed = found.prior.qpos[:, 0] - np.sin(speed * found.begin)
    astray = found.prior.qvel[:, 0] - speed * np.cos(speed * found.begin)
    assert np.sqrt((missed**2).mean()) < found.prior.std[0]
    assert np.sqrt((astray**2).mean()) < found.prior.std[1]


@pytest.mark.parametrize("smoother", [0.03, 0.3])
def test_no_later_sample_is_known_at_a_predicted_start(smoother: float) -> None:
    settings = predicted_settings(smoother=smoother, seconds=0.9)
    before = log(hinge_position=np.sin(5 * TIME))
    starts = windows(before, settings)
    for k, begin in enumerate(starts.begin):
        later = begin + settings.margin + settings.run_in <= TIME
        after = log(hinge_position=np.sin(5 * TIME) + later)
        assert _same(windows(after, settings).prior, starts.prior, k)
        earlier = log(hinge_position=np.sin(5 * TIME) + np.roll(later, -1))
        assert _same(windows(earlier, settings).prior, starts.prior, k) == (smoother < settings.run_in)


def _same(one: StartPrior, other: StartPrior, window: int) -> bool:
    pairs = ((one.qpos, other.qpos), (one.qvel, other.qvel), (one.qacc, other.qacc))
    return all(np.array_equal(a[window], b[window]) for a, b in pairs)


def test_a_sample_at_the_end_of_the_run_in_is_not_known() -> None:
    grid = clock(2000)
    settings = predicted_settings(smoother=0.3, seconds=1.2)

    def prior(value: Array) -> StartPrior:
        one = Log("a", {"hinge.position": Signal("hinge.position", "rad", grid, value)}, {})
        return cut([one], measured([one]), pendulum().nominal(), settings).prior

    flat = Log("a", {"hinge.position": Signal("hinge.position", "rad", grid, grid)}, {})
    found = cut([flat], measured([flat]), pendulum().nominal(), settings)
    for k, (begin, first) in enumerate(zip(found.begin, np.argmax(found.samples[0].scored, axis=1), strict=True)):
        scored = grid >= begin + found.samples[0].time[k, first] - 1e-9
        assert _same(prior(grid + scored), found.prior, k)


def test_windows_whose_start_nothing_tells_are_left_out() -> None:
    slow = clock(80, 0.05)  # 20 Hz: four samples need 0.15 s
    one = Log("a", {"hinge.position": Signal("hinge.position", "rad", slow, np.sin(slow))}, {})
    found = cut([one], measured([one]), pendulum().nominal(), predicted_settings())
    assert found.begin.min() > 0.03
    assert found.begin.min() < 0.4


def test_a_joint_whose_velocity_alone_is_measured_starts_at_it() -> None:
    found = windows(log(rail_velocity=2 + 3 * TIME, hinge_position=0.5 * TIME), windows_settings(), CARTPOLE)
    np.testing.assert_allclose(found.prior.qvel, np.stack([2 + 3 * found.begin, np.full(len(found), 0.5)], 1))
    np.testing.assert_allclose(found.prior.qacc[:, 0], 3.0)
    np.testing.assert_allclose(found.prior.qpos[:, 0], 0.0)
    settings = windows_settings()
    assert found.prior.std[0] == settings.unmeasured_position
    assert found.prior.std[2] == pytest.approx(settings.prior_scale * NOISE)


def test_a_measured_position_outranks_a_velocity() -> None:
    both = windows(log(hinge_position=TIME**2, hinge_velocity=7 + 0 * TIME), windows_settings())
    np.testing.assert_allclose(both.prior.qvel[:, 0], 2 * both.begin, atol=1e-7)


def test_a_joint_without_a_channel_starts_at_the_reference() -> None:
    found = windows(log(rail_position=TIME), windows_settings(), CARTPOLE)
    settings = windows_settings()
    np.testing.assert_allclose(found.prior.qpos[:, 1], 0.2)
    np.testing.assert_allclose(found.prior.qvel[:, 1], 0.0)
    np.testing.assert_allclose(found.prior.std[[1, 3]], [settings.unmeasured_position, settings.unmeasured_velocity])


def test_starts_follow_the_order_of_the_logs() -> None:
    one = log(hinge_position=TIME)
    two = replace(log(hinge_position=10 + TIME), name="b")
    found = cut([one, two], measured([one, two]), pendulum().nominal(), windows_settings())
    np.testing.assert_allclose(found.prior.qpos[:, 0], found.begin + 10 * found.log)


def test_far_past_is_mean_velocities_and_rest_before_the_log() -> None:
    settings = windows_settings()
    found = windows(log(hinge_position=1.5 * TIME), settings)
    edges = settings.interval * np.arange(found.before.far.shape[1] + 1)
    for begin, speeds in zip(found.begin, found.before.far[:, :, 0], strict=True):
        starts = begin - settings.memory - edges[-1] + edges[:-1]
        inside, outside = starts >= TIME[0], starts + settings.interval <= TIME[0]
        np.testing.assert_allclose(speeds[inside], 1.5, rtol=1e-9)
        np.testing.assert_array_equal(speeds[outside], 0.0)
    assert edges[-1] == pytest.approx(settings.lookback - settings.memory)
