from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import evidence_settings, pendulum, solver_settings, swinging, windows_of

from dr_lab.diagnosis.blocks import blocks, logs
from dr_lab.diagnosis.fit import Fit, Fitter
from dr_lab.diagnosis.left_out import left_out
from dr_lab.diagnosis.replay import Replay
from dr_lab.diagnosis.states import fit_states
from dr_lab.diagnosis.windows import Windows
from dr_lab.physics.context import ContextSpace
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
    others = Fitter(Replay(model, rest, 1), solver_settings()).run(fit.z)
    _, alone = fit_states(model, others.z, windows.pick(rows), solver_settings(), 1)
    foretold = left_out(fit, model.space, windows.log, settings)[rows]
    ours, theirs, seen = (float(np.square(r).sum()) for r in (foretold, alone.residuals, fit.residuals[rows]))
    assert theirs > 1.002 * seen  # a fit flatters the windows that it saw
    assert ours - seen == pytest.approx(theirs - seen, rel=0.25)


def test_a_parameter_at_its_bound_stays_there() -> None:
    model, settings = pendulum(), evidence_settings()
    windows, fit = fitted(model, [0.597, 0.600, 0.603])
    bound = replace(fit, z=np.array([fit.z[0], model.space.low[1]]))
    gradient = fit.equations.window_information()[1].sum(0)[1] + fit.equations.prior_gradient[1]
    pushed = replace(fit.equations, prior_gradient=fit.equations.prior_gradient + np.array([0.0, 1e6 - gradient]))
    held = left_out(replace(bound, equations=pushed), model.space, windows.log, settings)
    alone = replace(pushed, mixed=pushed.mixed[..., :1], parameter=pushed.parameter[:, :1, :1])
    small = replace(alone, parameter_gradient=pushed.parameter_gradient[:, :1], prior=pushed.prior[:1])
    only = replace(small, prior_gradient=pushed.prior_gradient[:1])
    slopes = replace(fit.slopes, parameter=fit.slopes.parameter[..., :1])
    first = ContextSpace(model.space.parameters[:1])
    expected = left_out(replace(fit, z=fit.z[:1], equations=only, slopes=slopes), first, windows.log, settings)
    np.testing.assert_allclose(held, expected, rtol=1e-6, atol=1e-9)
