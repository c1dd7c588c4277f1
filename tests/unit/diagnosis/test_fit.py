from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import (
    NOISE,
    PENDULUM,
    PENDULUM_PARAMETERS,
    dragged,
    evidence_settings,
    formal_std,
    log_of,
    model_of,
    pendulum,
    slow_then_fast,
    solver_settings,
    swinging,
    windows_of,
    windows_settings,
)
from numpy.typing import NDArray

from dr_lab.diagnosis.fit.covariance import estimate
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.objective import Objective
from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.slopes import Slopes
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array, Log

TRUTH = np.array([0.6, 0.08])


def fitted(model: Model, logs: list[Log], start: Array | None = None) -> Fit:
    replay = Replay(model, windows_of(model, logs), 1)
    return Fitter(replay, solver_settings()).run(model.space.nominal if start is None else start)


def logs_of(model: Model, truth: Array, count: int, first: int = 0, seconds: float = 3.0) -> list[Log]:
    compiled = model.compile(truth)
    return [swinging(f"log_{k}", compiled, first + k, seconds=seconds) for k in range(count)]


def test_hidden_values_are_recovered_within_their_uncertainty() -> None:
    model = pendulum()
    fit = fitted(model, logs_of(model, TRUTH, 3))
    np.testing.assert_allclose(fit.z, TRUTH, rtol=3e-3)
    std = formal_std(model, fit)
    assert (std / TRUTH < 2e-3).all()
    assert (np.abs(fit.z - TRUTH) < 4 * std).all()
    count = Fitter(Replay(model, windows_of(model, logs_of(model, TRUTH, 3)), 1), solver_settings()).replay.fitted.sum()
    assert fit.cost == pytest.approx(count, rel=0.06)


@pytest.mark.slow
def test_uncertainties_are_those_of_repeated_experiments() -> None:
    model = pendulum()
    errors = []
    for seed in range(20):
        fit = fitted(model, logs_of(model, TRUTH, 2, first=10 * seed, seconds=1.5))
        errors.append((fit.z - TRUTH) / formal_std(model, fit))
    assert np.abs(np.mean(errors, axis=0)).max() < 0.75  # 3.4 standard errors
    assert 0.75 < np.std(errors) < 1.3  # 40 figures: ±11 % at one standard deviation


def test_glitches_do_not_move_the_estimate() -> None:
    model, rng = pendulum(), np.random.default_rng(0)
    clean = logs_of(model, TRUTH, 2)
    spoilt = []
    for log in clean:
        signal = log.outputs["hinge.position"]
        hit = rng.uniform(size=len(signal)) < 0.01
        value = signal.value + np.where(hit, rng.choice([-1.0, 1.0], len(signal)), 0.0)  # 1000 σ
        spoilt.append(log_of(log.name, {"hinge.position": (signal.time, value)}, log.commands["drive"]))
    one, other = fitted(model, clean), fitted(model, spoilt)
    # A hundredth of the samples pulls with five standard deviations each: √(0.01 · 5²) = 0.5 of the estimate's own.
    assert (np.abs(one.z - other.z) < 3 * 0.5 * formal_std(model, one)).all()


def test_values_stay_within_their_bounds() -> None:
    narrow = {**PENDULUM_PARAMETERS, "rod.mass": {**PENDULUM_PARAMETERS["rod.mass"], "high": 0.55}}
    model = model_of(PENDULUM, narrow)
    fit = fitted(model, logs_of(pendulum(), TRUTH, 2))
    assert fit.z[0] == 0.55
    assert model.space.low[1] < fit.z[1] < model.space.high[1]


def test_a_value_at_its_bound_is_found_there() -> None:
    model = pendulum()
    fit = fitted(model, logs_of(model, np.array([0.6, 0.0]), 2))
    assert 0.0 <= fit.z[1] < 4 * formal_std(model, fit)[1]
    assert fit.z[0] == pytest.approx(0.6, rel=3e-3)


SERVO = """<mujoco model="servo">
  <compiler angle="radian"/><option timestep="0.002" integrator="RK4"/>
  <worldbody><body><inertial mass="0.5" pos="0 0 -0.3" diaginertia="0.005 0.005 0.001"/>
    <joint name="hinge" axis="0 1 0" damping="0.05" stiffness="5"/></body></worldbody>
  <actuator><motor name="drive" joint="hinge"/></actuator>
</mujoco>"""


SPRING = {"stiffness": {"target": "joint.hinge.stiffness", "unit": "N·m/rad", "low": 0.5, "high": 50.0}}


@pytest.mark.parametrize("start", [1.0, 30.0])
def test_windows_reach_the_truth_from_far_starts(start: float) -> None:
    model = model_of(SERVO, SPRING)
    logs = logs_of(model, np.array([6.0]), 2)
    assert fitted(model, logs, np.array([start])).z[0] == pytest.approx(6.0, rel=1e-3)


def test_one_long_rollout_does_not() -> None:
    model = model_of(SERVO, SPRING)
    whole = windows_of(model, logs_of(model, np.array([6.0]), 2), windows_settings(length=2.8))
    stuck = Fitter(Replay(model, whole, 1), solver_settings()).run(np.array([30.0]))
    assert stuck.z[0] != pytest.approx(6.0, rel=0.1)


def test_known_slopes_change_the_work_but_not_the_answer() -> None:
    model = pendulum()
    fitter = Fitter(Replay(model, windows_of(model, logs_of(model, TRUTH, 2)), 1), solver_settings(tolerance=1e-9))
    plain = fitter.run(model.space.nominal)
    again = fitter.run(plain.z, plain.delta, plain.slopes)
    assert again.cost <= plain.cost * (1 + 1e-9)
    np.testing.assert_allclose(again.z, plain.z, rtol=1e-4)
    misled = fitter.run(model.space.nominal, None, plain.slopes)
    assert misled.cost == pytest.approx(plain.cost, rel=1e-6)


def test_small_batches_change_nothing_but_the_memory() -> None:
    model, logs = pendulum(), logs_of(pendulum(), TRUTH, 2)
    whole, parts = (
        Fitter(Replay(model, windows_of(model, logs), 1), solver_settings(batch=batch)).run(model.space.nominal)
        for batch in (4096, 30)
    )
    np.testing.assert_array_equal(whole.z, parts.z)
    np.testing.assert_array_equal(whole.slopes.state, parts.slopes.state)


def test_the_equations_are_those_at_the_solution() -> None:
    model = pendulum()
    fitter = Fitter(Replay(model, windows_of(model, logs_of(model, TRUTH, 2)), 1), solver_settings())
    fit = fitter.run(model.space.nominal)
    step, _ = fit.equations.step(0.0, np.ones(2, bool))
    assert (np.abs(step) * model.space.span < 0.05 * formal_std(model, fit)).all()


def test_the_formal_covariance_is_part_of_the_estimate() -> None:
    model = pendulum()
    windows = windows_of(model, logs_of(model, TRUTH, 4))
    fit = Fitter(Replay(model, windows, 1), solver_settings()).run(model.space.nominal)
    found = estimate(model.space, fit, windows, evidence_settings())
    assert (found.std >= 0.999 * formal_std(model, fit)).all()
    assert (found.std < 3 * formal_std(model, fit)).all()
    assert windows.samples[0].std == NOISE


def test_a_start_takes_in_each_window_the_better_of_given_and_expected_states() -> None:
    model = pendulum()
    fit = fitted(model, logs_of(model, TRUTH, 1))
    fitter = Fitter(Replay(model, windows_of(model, logs_of(model, TRUTH, 1)), 1), solver_settings())
    bent = fit.delta.copy()
    bent[::2] += 10 * fitter.replay.windows.prior.std
    start = fitter.begin(fit.z, bent)
    np.testing.assert_array_equal(start.delta[::2], 0.0)
    np.testing.assert_array_equal(start.delta[1::2], fit.delta[1::2])
    np.testing.assert_allclose(start.residuals[1::2], fit.residuals[1::2], atol=1e-9)


def from_a_light_start(start: float, **changes: float) -> tuple[int, Fit]:
    """Fit of a log whose fast windows diverge at the start, and the number of these."""
    model = dragged(1.0)
    replay = Replay(model, windows_of(model, [slow_then_fast("log", 0)]), 1)
    _, diverging = replay.residuals(np.array([[start]]), np.zeros((1, len(replay.windows), replay.nstate)))
    return int(diverging.sum()), Fitter(replay, solver_settings(**changes)).run(np.array([start]))


def test_windows_that_diverge_at_the_start_come_back() -> None:
    diverging, fit = from_a_light_start(0.05)
    assert diverging > 0
    assert not fit.infeasible.any()
    assert fit.converged
    assert fit.z[0] == pytest.approx(1.0, rel=2e-3)
    assert fit.cost == pytest.approx(fit.residuals.size, rel=0.25)


def test_a_fit_that_could_have_windows_back_is_not_converged() -> None:
    diverging, fit = from_a_light_start(0.05, restarts=0)
    assert fit.infeasible.sum() == diverging
    assert not fit.converged


def test_fits_are_compared_in_windows_that_neither_lets_diverge() -> None:
    (count, few), (_, all_of_them) = from_a_light_start(0.05, restarts=0), from_a_light_start(0.05)
    kept = ~few.infeasible
    assert few.infeasible.sum() == count
    assert all_of_them.below(few) == pytest.approx(few.cost - all_of_them.window_costs[kept].sum(), rel=1e-3, abs=0.1)
    assert few.below(all_of_them) == pytest.approx(-all_of_them.below(few))
    assert all_of_them.window_costs.sum() == pytest.approx(all_of_them.cost, rel=1e-3)


def test_residuals_that_are_no_numbers_leave_a_finite_cost() -> None:
    model, logs = pendulum(), logs_of(pendulum(), TRUTH, 1)
    fit = Fitter(Replay(model, windows_of(model, logs, noise=1e-200), 1), solver_settings()).run(model.space.nominal)
    assert fit.infeasible.all()
    assert np.isfinite(fit.cost)
    assert not fit.converged


def test_a_fit_without_iterations_is_not_converged() -> None:
    model = pendulum()
    fitter = Fitter(Replay(model, windows_of(model, logs_of(model, TRUTH, 1)), 1), solver_settings())
    assert fitter.run(model.space.nominal).converged
    assert not fitter.run(model.space.nominal, iterations=0).converged


@pytest.mark.parametrize(("crawl", "patient", "taken"), [(3, False, 3), (9, False, 9), (9, True, 18)])
def test_a_descent_that_crawls_ends_and_begins_not_anew(
    crawl: int, patient: bool, taken: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each step gains a twentieth of a deviance of 1, though a linear step foretells much."""

    def crawling(self: Fitter, best: Point, *_: object) -> tuple[Point, float, float]:
        return replace(best, cost=best.cost - 0.05 * Objective(replay, settings).negligible(best, 1.0)), 1.0, 1e9

    def left(self: Fitter, best: Point, trial: Point, slopes: Slopes, *_: object) -> tuple[Point, Slopes]:
        return trial, slopes

    monkeypatch.setattr(Fitter, "_trial", crawling)
    monkeypatch.setattr(Fitter, "_mended", left)
    model, settings = pendulum(), solver_settings(crawl=crawl, pace=20, iterations=40, restarts=1, stray=1e9)
    replay = Replay(model, windows_of(model, logs_of(model, TRUTH, 1)), 1)
    fit = Fitter(replay, settings.patient if patient else settings).run(model.space.nominal)
    assert not fit.converged
    assert fit.iterations == taken


def test_linear_models_of_one_batch_are_those_of_single_runs() -> None:
    model = pendulum()
    fitter = Fitter(Replay(model, windows_of(model, logs_of(model, TRUTH, 1)), 1), solver_settings())
    base = fitter.run(model.space.nominal)
    contexts = np.stack([base.z, model.space.clip(1.1 * base.z)])
    known = Slopes(base.slopes.state, base.slopes.parameter[..., :0])
    for z, found in zip(contexts, fitter.outlooks(contexts, base.delta, known, base), strict=True):
        alone = fitter.run(z, base.delta, known, iterations=0)
        assert found.cost == pytest.approx(alone.cost)
        np.testing.assert_allclose(
            found.slopes.parameter, alone.slopes.parameter, atol=1e-3 * np.abs(alone.slopes.parameter).max()
        )


def test_a_fit_goes_on_from_a_linear_model_as_from_its_context(monkeypatch: pytest.MonkeyPatch) -> None:
    model = pendulum()
    fitter = Fitter(Replay(model, windows_of(model, logs_of(model, TRUTH, 1)), 1), solver_settings())
    nominal = model.space.nominal
    there = fitter.run(nominal, iterations=0)
    replayed: list[int] = []
    residuals = Replay.residuals

    def counted(self: Replay, z: Array, delta: Array) -> tuple[Array, NDArray[np.bool_]]:
        replayed.append(len(z))
        return residuals(self, z, delta)

    monkeypatch.setattr(Replay, "residuals", counted)
    alone = fitter.run(nominal)
    needed = sum(replayed)
    replayed.clear()
    found = fitter.go_on(there)
    np.testing.assert_allclose(found.z, alone.z, rtol=1e-9)
    assert found.converged
    start_and_slopes = 2 + there.slopes.state.shape[2] + len(nominal)  # the start by cheaper steps, too
    assert sum(replayed) == needed - start_and_slopes
