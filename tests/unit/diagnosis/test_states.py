from dataclasses import replace

import mujoco
import numpy as np
import pytest
from diagnosis_machines import (
    NOISE,
    log_of,
    model_of,
    pendulum,
    predicted_settings,
    simulated,
    solver_settings,
    steps_command,
    swinging,
    windows_of,
    windows_settings,
)
from effect_machines import catalogue_effect, scales_of
from scipy.optimize import least_squares

from dr_lab.diagnosis.fit.active_windows import ActiveWindows
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import StateFit, _Search, fit_states
from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.effects.effect import place
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array

EXACT = solver_settings(tolerance=1e-12, iterations=50, huber=1e9)
WRONG = np.array([0.6, 0.1])
SOFT = {"smooth_friction@hinge.torque": 0.05, "smooth_friction@hinge.creep": 0.01}  # N·m, rad/s


def brute(replay: Replay, z: Array, window: int) -> tuple[Array, float]:
    """The best start of one window, and its cost."""
    std = replay.windows.prior.std

    def cost(x: Array) -> Array:
        delta = np.zeros((1, len(replay.windows), 2))
        delta[0, window] = x * std
        found = replay.residuals(z[None], delta)[0][0, window]
        return np.concatenate([found[replay.fitted[window]], x])

    found = least_squares(cost, np.zeros(2), xtol=1e-14, ftol=1e-14, gtol=1e-14, x_scale="jac")
    return found.x * std, 2 * found.cost


@pytest.mark.parametrize("settings", [None, predicted_settings()])
def test_states_are_those_of_a_general_solver(settings: WindowSettings | None) -> None:
    model = pendulum()
    windows = windows_of(model, [swinging("a", model.nominal(), 0, seconds=1.2)], settings)
    replay, fit = fit_states(model, WRONG, windows, EXACT, 1)
    for window in range(len(windows)):
        best, cost = brute(replay, WRONG, window)
        np.testing.assert_allclose((fit.delta[window] - best) / windows.prior.std, 0.0, atol=2e-3)
        squares = (fit.residuals[window, replay.fitted[window]] ** 2).sum()
        assert squares + ((fit.delta[window] / windows.prior.std) ** 2).sum() == pytest.approx(cost, rel=1e-6)


def test_starts_from_a_bad_neighbour_end_where_cold_starts_do() -> None:
    model = pendulum()
    windows = windows_of(model, [swinging("a", model.nominal(), 0)])
    _, cold = fit_states(model, WRONG, windows, EXACT, 1)
    rng = np.random.default_rng(0)
    far = cold.delta + 40 * rng.normal(size=cold.delta.shape) * windows.prior.std
    near = StateFit(cold.z, far, cold.residuals, np.inf, cold.infeasible, rng.normal(size=cold.slopes.shape))
    _, warm = fit_states(model, WRONG, windows, EXACT, 1, near)
    np.testing.assert_allclose((warm.delta - cold.delta) / windows.prior.std, 0.0, atol=1e-3)
    assert warm.cost == pytest.approx(cold.cost, rel=1e-6)


def test_poor_states_are_looked_for_again_from_the_priors_mean() -> None:
    model, once = pendulum(), replace(solver_settings(), iterations=1)
    windows = windows_of(model, [swinging("a", model.nominal(), 0)])
    _, cold = fit_states(model, WRONG, windows, once, 1)
    misled = np.arange(len(windows))[:, None, None] < 2
    misleading = np.random.default_rng(0).normal(size=cold.slopes.shape)
    delta = np.where(misled[..., 0], 100.0 * windows.prior.std, cold.delta)
    near = replace(cold, delta=delta, slopes=np.where(misled, misleading, cold.slopes))
    _, warm = fit_states(model, WRONG, windows, once, 1, near)
    np.testing.assert_array_equal(warm.delta[:2], cold.delta[:2])


def test_the_default_settings_come_close_to_the_best_states() -> None:
    model = pendulum()
    windows = windows_of(model, [swinging("a", model.nominal(), 0)])
    _, exact = fit_states(model, model.space.nominal, windows, EXACT, 1)
    _, quick = fit_states(model, model.space.nominal, windows, solver_settings(), 1)
    assert quick.cost < 1.001 * exact.cost


TUMBLING = """<mujoco model="tumbling"><option timestep="0.002" integrator="RK4"/><worldbody>
  <body><inertial mass="0.5" pos="0 0 -0.2" diaginertia="0.002 0.002 0.002"/><joint name="upper" axis="0 1 0"/>
    <body pos="0 0 -0.3"><inertial mass="0.5" pos="0 0 -0.2" diaginertia="0.002 0.002 0.002"/>
      <joint name="lower" axis="0 1 0"/></body></body></worldbody>
  <actuator><motor name="drive" joint="upper"/></actuator></mujoco>"""


def test_starts_of_long_windows_of_a_chaotic_machine_are_found() -> None:
    """A double pendulum without friction tumbles; over 2.7 s an error of its start grows a thousandfold."""
    model, random = model_of(TUMBLING), np.random.default_rng(5)
    command = steps_command("drive", 1.0, 12.0, 5)
    motion = simulated(model.nominal(), command, 12.0, qpos=random.uniform(-3.0, 3.0, 2).tolist())
    reading = motion["qpos"] + NOISE * random.normal(size=motion["qpos"].shape)
    outputs = {f"{name}.position": (motion["time"], reading[:, k]) for k, name in enumerate(("upper", "lower"))}
    settings = windows_settings(length=2.7, seconds=60.0)
    windows = windows_of(model, [log_of("a", outputs, command)], settings)
    replay, fit = fit_states(model, model.space.nominal, windows, solver_settings(), 1)
    search = _Search(replay, solver_settings(), model.space.nominal)
    mean = search.point(np.zeros_like(fit.delta))
    at_once = search.descend(mean, None, ~mean.infeasible)
    assert (search._left(at_once) > 100.0).sum() > len(windows) / 2
    np.testing.assert_allclose(search._left(fit), 1.0, atol=0.15)


def unstable() -> Model:
    """Damping explodes the explicit integrator above 2·inertia/timestep."""
    xml = """<mujoco model="u"><option timestep="0.002" integrator="Euler" gravity="0 0 0"><flag eulerdamp="disable"/>
      </option><worldbody><body><inertial mass="1" pos="0 0 0" diaginertia="1e-3 1e-3 1e-3"/>
      <joint name="hinge" axis="0 1 0" damping="0.5"/></body></worldbody>
      <actuator><motor name="drive" joint="hinge"/></actuator></mujoco>"""
    return model_of(xml, {"damping": {"target": "joint.hinge.damping", "unit": "", "low": 0.0, "high": 100.0}})


def test_windows_that_diverge_are_marked_and_leave_the_others_alone() -> None:
    model = unstable()
    windows = windows_of(model, [swinging("a", pendulum().nominal(), 0)])
    replay, fit = fit_states(model, np.array([80.0]), windows, solver_settings(), 1)
    assert fit.infeasible.all()
    _, fine = fit_states(model, np.array([0.5]), windows, solver_settings(), 1)
    assert not fine.infeasible.any()
    assert np.isfinite(fit.residuals[replay.scored]).all()


def test_of_windows_with_a_run_in_the_start_is_that_of_the_run_in_alone() -> None:
    model, settings = pendulum(), predicted_settings()
    windows = windows_of(model, [swinging("a", model.nominal(), 0)], settings)
    replay, fit = fit_states(model, WRONG, windows, EXACT, 1)
    part = replay.until_known()
    steps = part.windows.controls.shape[1] * windows.step
    assert settings.run_in + 2 * settings.margin <= steps < settings.run_in + 2 * settings.margin + 3 * windows.step
    _, known = fit_states(model, WRONG, part.windows, EXACT, 1)
    np.testing.assert_array_equal(fit.delta, known.delta)
    np.testing.assert_array_equal(fit.residuals, replay.residuals(WRONG[None], fit.delta[None])[0][0])
    assert np.abs(fit.residuals[replay.scored]).max() > 0


def test_some_of_the_windows_have_the_states_that_they_have_among_all() -> None:
    model, rows = pendulum(), np.array([1, 4, 5])
    windows = windows_of(model, [swinging(name, model.nominal(), k) for k, name in enumerate("ab")])
    _, every = fit_states(model, WRONG, windows, EXACT, 1)
    _, some = fit_states(model, WRONG, windows.pick(rows), EXACT, 1)
    np.testing.assert_array_equal(some.delta, every.delta[rows])
    np.testing.assert_array_equal(some.residuals, every.residuals[rows])


def test_where_a_law_acts_few_windows_try_several_steps_at_once() -> None:
    model = pendulum()
    soft = place(catalogue_effect("smooth_friction"), model.nominal(), "hinge", scales_of(model, torque=0.5))
    windows = windows_of(model, [swinging("a", model.nominal(), 0)])
    rubbed = model.with_effect(soft)
    z, rows = rubbed.space.vector({**dict(zip(rubbed.space.names, rubbed.space.nominal, strict=True)), **SOFT}), 3
    replay, fit = fit_states(rubbed, z, windows.pick(np.arange(rows)), EXACT, 1)
    few = ActiveWindows(replay, np.arange(rows), EXACT)
    assert few.at_once == 4
    assert ActiveWindows(Replay(model, windows, 1), np.arange(rows), EXACT).at_once == 1
    assert ActiveWindows(Replay(rubbed, windows, 1), np.arange(len(windows)), EXACT).at_once == 1
    steps = 1e-3 * np.arange(4)[:, None, None] * np.ones_like(fit.delta)
    for found, step in zip(few.tried(fit, steps), steps, strict=True):
        (alone,) = few.tried(fit, step[None])
        np.testing.assert_array_equal(found.delta, fit.delta + step)
        np.testing.assert_array_equal(found.residuals, alone.residuals)


def test_slopes_of_another_model_mislead_no_step_of_those_that_are_tried_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """More damping lets a step along old slopes gain a little, where one step alone fails and asks for new ones."""

    def rub(data: mujoco.MjData) -> None:
        data.qfrc_applied[0] = -0.4 * np.tanh(data.qvel[0] / 0.02)

    model = pendulum()
    soft = place(catalogue_effect("smooth_friction"), model.nominal(), "hinge", scales_of(model, torque=0.5))
    rubbed = model.with_effect(soft)
    windows = windows_of(model, [swinging("a", model.nominal(), 0, force=rub)]).pick(np.arange(4))
    _, near = fit_states(model, model.space.nominal, windows, solver_settings(), 1)
    values = {"smooth_friction@hinge.torque": 0.3, "smooth_friction@hinge.creep": 0.02}
    z = rubbed.space.vector({**dict(zip(rubbed.space.names, rubbed.space.nominal, strict=True)), **values})
    costs = list[float]()
    for most in (4, 1):
        monkeypatch.setattr("dr_lab.diagnosis.fit.active_windows._AT_ONCE", most)
        costs.append(fit_states(rubbed, z, windows, solver_settings(), 1, near)[1].cost)
    assert costs[0] <= 1.001 * costs[1]


def test_few_active_windows_are_simulated_alone_and_the_others_stay() -> None:
    model = pendulum()
    windows = windows_of(model, [swinging("a", model.nominal(), 0)])
    replay, fit = fit_states(model, WRONG, windows, solver_settings(), 1)
    active = np.zeros(len(windows), bool)
    active[[0, 3]] = True
    whole = ActiveWindows(replay, np.arange(len(windows)), solver_settings())
    assert whole.narrowed(np.ones(len(windows), bool)) is whole
    part = whole.narrowed(active)
    assert len(part.replay.windows) == 2
    step = np.full_like(fit.delta, 1e-3)
    (moved,), (every,) = part.tried(fit, step[None]), whole.tried(fit, step[None])
    np.testing.assert_array_equal(moved.residuals, np.where(active[:, None], every.residuals, fit.residuals))
    np.testing.assert_array_equal(moved.delta, np.where(active[:, None], fit.delta + step, fit.delta))
    slopes = part.renew(fit, np.zeros_like(fit.slopes))
    np.testing.assert_array_equal(slopes != 0, (whole.renew(fit, fit.slopes) != 0) & active[:, None, None])
