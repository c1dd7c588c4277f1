from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import evidence_settings, pendulum, solver_settings, swinging, windows_of

from dr_lab.diagnosis.evidence.left_out import left_out
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.diagnosis.windows.blocks import blocks, logs
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.physics.model import Model


def fitted(model: Model, masses: list[float], seconds: float = 2.0) -> tuple[Windows, Fit]:
    recorded = [
        swinging(f"log_{k}", model.compile(np.array([mass, 0.08])), k, seconds=seconds) for k, mass in enumerate(masses)
    ]
    windows = windows_of(model, recorded)
    return windows, Fitter(Replay(model, windows, 1), solver_settings()).run(model.space.nominal)


@pytest.mark.parametrize(
    ("masses", "place"),
    [([0.58, 0.62], 0), ([0.58, 0.62], 3), ([0.597, 0.600, 0.603], 0), ([0.597, 0.600, 0.603], 2)],
    ids=["a block of two logs", "another one", "one of three logs", "another log"],
)
def test_windows_are_foretold_as_a_fit_to_all_others_foretells_them(masses: list[float], place: int) -> None:
    model, settings = pendulum(), evidence_settings()
    windows, fit = fitted(model, masses)
    parts = blocks(windows.log, settings.block, settings.least_blocks) if len(masses) == 2 else logs(windows.log)
    rows = parts[place]
    rest = windows.pick(np.setdiff1d(np.arange(len(windows)), rows))
    others = Fitter(Replay(model, rest, 1), solver_settings(tolerance=1e-4)).run(fit.z)
    _, alone = fit_states(model, others.z, windows.pick(rows), solver_settings(), 1)
    foretold = left_out(Replay(model, windows, 1), fit, solver_settings(), settings).residuals[rows]
    ours, theirs, seen = (float(np.square(r).sum()) for r in (foretold, alone.residuals, fit.residuals[rows]))
    assert theirs > 1.002 * seen  # a fit flatters the windows that it saw
    assert ours - seen == pytest.approx(theirs - seen, rel=0.25)


def test_a_step_that_goes_astray_gives_way_to_a_refit() -> None:
    model, settings = pendulum(), evidence_settings()
    windows, fit = fitted(model, [0.597, 0.600, 0.603])
    replay, rows = Replay(model, windows, 1), logs(windows.log)[1]
    honest = left_out(replay, fit, solver_settings(), settings)
    slopes = replace(fit.slopes, parameter=100 * fit.slopes.parameter)  # foretell a hundred times as much
    astray = left_out(replay, replace(fit, slopes=slopes), solver_settings(), settings)
    ours, theirs = (float(np.square(found.residuals[rows]).sum()) for found in (astray, honest))
    assert ours != theirs
    assert ours == pytest.approx(theirs, rel=1e-3)


def test_a_parameter_at_its_bound_stays_there() -> None:
    mass, damping = pendulum().declared
    model = replace(pendulum(), declared=(mass, replace(damping, low=0.09, nominal=0.1)))
    windows, fit = fitted(model, [0.597, 0.600, 0.603])
    assert fit.z[1] == pytest.approx(0.09)
    fixed = replace(model, spec=model.spec_at(np.array([mass.nominal, 0.09])), declared=(mass,))
    alone = Fitter(Replay(fixed, windows, 1), solver_settings()).run(fit.z[:1])
    held, expected = (
        left_out(Replay(m, windows, 1), f, solver_settings(), evidence_settings()).residuals
        for m, f in ((model, fit), (fixed, alone))
    )
    # With its damping free they would leave a third of that.
    np.testing.assert_allclose(np.square(held).sum(), np.square(expected).sum(), rtol=0.01)


def test_a_lone_window_is_foretold_by_what_is_known_without_it() -> None:
    model, solver = pendulum(), solver_settings()
    windows, whole = fitted(model, [0.6, 0.6, 0.6])
    alone = windows.pick(np.array([0]))
    fit = Fitter(Replay(model, alone, 1), solver).run(whole.z)
    found = left_out(Replay(model, alone, 1), fit, solver, evidence_settings())
    assert np.isfinite(found.residuals).all()
    assert np.square(found.residuals).sum() > np.square(fit.residuals).sum()
