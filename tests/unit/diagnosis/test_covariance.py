import numpy as np
import pytest
from diagnosis_machines import evidence_settings, formal_std, pendulum, solver_settings, swinging, windows_of

from dr_lab.diagnosis.fit.covariance import estimate, per_log
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.physics.model import Model

TRUTH = np.array([0.6, 0.08])


def fitted(model: Model, masses: list[float], seconds: float = 2.0) -> tuple[Windows, Fit]:
    logs = [
        swinging(f"log_{k}", model.compile(np.array([mass, 0.08])), k, seconds=seconds) for k, mass in enumerate(masses)
    ]
    windows = windows_of(model, logs)
    return windows, Fitter(Replay(model, windows, 1), solver_settings()).run(model.space.nominal)


def test_logs_that_agree_keep_the_formal_uncertainty() -> None:
    model = pendulum()
    windows, fit = fitted(model, [0.6] * 5)
    found = estimate(model.space, fit, windows, evidence_settings())
    assert (found.std >= 0.999 * formal_std(model, fit)).all()
    assert (found.std < 2.5 * formal_std(model, fit)).all()


def test_logs_that_disagree_widen_it_to_their_scatter() -> None:
    model = pendulum()
    masses = [0.55, 0.65, 0.55, 0.65, 0.55, 0.65]
    windows, fit = fitted(model, masses)
    found = estimate(model.space, fit, windows, evidence_settings())
    standard_error = np.std(masses, ddof=1) / np.sqrt(len(masses))
    assert found.std[0] > 10 * formal_std(model, fit)[0]
    assert found.std[0] == pytest.approx(standard_error, rel=0.35)
    assert abs(found.mean[0] - np.mean(masses)) < 2 * found.std[0]


def test_each_log_prefers_its_own_truth() -> None:
    model = pendulum()
    masses = [0.58, 0.60, 0.62]
    windows, fit = fitted(model, masses)
    np.testing.assert_allclose(per_log(model.space, fit, windows)[:, 0], masses, rtol=0.01)


def test_the_parts_of_a_single_log_are_resampled() -> None:
    model = pendulum()
    logs = [swinging("a", model.compile(np.array([mass, 0.08])), k) for k, mass in enumerate((0.55, 0.65))]
    windows = windows_of(model, logs)
    fit = Fitter(Replay(model, windows, 1), solver_settings()).run(model.space.nominal)
    single = Windows(**{**vars(windows), "log": np.zeros_like(windows.log), "logs": ("a",)})
    found = estimate(model.space, fit, single, evidence_settings())
    assert found.std[0] > 10 * formal_std(model, fit)[0]


def test_one_window_has_no_scatter_but_an_uncertainty() -> None:
    model = pendulum()
    windows, fit = fitted(model, [0.6], seconds=0.6)
    assert len(windows) == 1
    found = estimate(model.space, fit, windows, evidence_settings())
    np.testing.assert_allclose(found.std, formal_std(model, fit))
