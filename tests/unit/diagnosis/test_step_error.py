"""What the time step does to what is fitted."""

import numpy as np
import pytest
from diagnosis_machines import (
    PENDULUM,
    PENDULUM_PARAMETERS,
    evidence_settings,
    model_of,
    solver_settings,
    swinging,
    windows_of,
)

from dr_lab.diagnosis.checks.numerical_floor import in_parts
from dr_lab.diagnosis.checks.step_error import step_shift
from dr_lab.diagnosis.evidence.bench import Bench, fit_and_score
from dr_lab.diagnosis.fit.covariance import estimate
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.search.uncertainty import known
from dr_lab.diagnosis.windows.finer import finer

PARTS = 16
NOISE = 1e-5  # rad


@pytest.mark.parametrize(
    ("integrator", "friction"),
    [
        pytest.param("Euler", 0.0, id="a smooth machine whose damping the step hides"),
        pytest.param("implicitfast", 0.05, id="dry friction"),
    ],
)
def test_a_fit_at_a_finer_step_is_foretold(integrator: str, friction: float) -> None:
    text = PENDULUM.replace("RK4", integrator).replace('damping="0.05"', f'damping="0.05" frictionloss="{friction}"')
    model = model_of(text, PENDULUM_PARAMETERS)
    fine = in_parts(model, PARTS)
    windows = windows_of(model, [swinging("a", fine.nominal(), 0, noise=NOISE)], noise=NOISE)
    replay = Replay(model, windows, 1)
    settings = solver_settings(tolerance=1e-3)
    coarse = Fitter(replay, settings).run(model.space.nominal)
    foretold = step_shift(replay, coarse, settings, 1)
    found = Fitter(Replay(fine, finer(windows, PARTS), 1), settings).run(coarse.z, coarse.delta)
    moved = model.space.to_unit(found.z) - model.space.to_unit(coarse.z)
    assert np.abs(moved).max() > 1e-4
    np.testing.assert_allclose(foretold, moved, atol=0.15 * np.abs(moved).max())


def test_the_stated_deviation_has_what_the_step_moved() -> None:
    text = PENDULUM.replace("RK4", "Euler")
    model = model_of(text, PENDULUM_PARAMETERS)
    fine = in_parts(model, PARTS)
    windows = windows_of(model, [swinging("a", fine.nominal(), 0, noise=NOISE)], noise=NOISE)
    bench = Bench(windows, windows, solver_settings(tolerance=1e-3), evidence_settings(), threads=1)
    coarse = fit_and_score(bench, model, model.space.nominal)
    away = np.abs(coarse.fit.z - [0.5, 0.05])  # the truth, kg and N·m·s/rad
    scatter = estimate(model.space, coarse.fit, windows, bench.evidence).std
    found, by_step = known(bench, coarse)
    np.testing.assert_allclose(np.sqrt(found.std**2 - scatter**2), by_step)
    np.testing.assert_allclose(by_step, away, rtol=0.15)
