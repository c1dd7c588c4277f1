import numpy as np
import pytest
from diagnosis_machines import evidence_settings, pendulum, solver_settings, swinging, windows_of

from dr_lab.diagnosis.blocks import blocks
from dr_lab.diagnosis.fit import Fit, Fitter
from dr_lab.diagnosis.left_out import left_out
from dr_lab.diagnosis.replay import Replay
from dr_lab.diagnosis.states import fit_states
from dr_lab.diagnosis.windows import Windows
from dr_lab.physics.model import Model


def fitted(model: Model, masses: list[float], seconds: float = 2.0) -> tuple[Windows, Fit]:
    logs = [
        swinging(f"log_{k}", model.compile(np.array([mass, 0.08])), k, seconds=seconds) for k, mass in enumerate(masses)
    ]
    windows = windows_of(model, logs)
    return windows, Fitter(Replay(model, windows, 1), solver_settings()).run(model.space.nominal)


@pytest.mark.parametrize("place", [0, 3, 7])
def test_windows_are_foretold_as_a_fit_to_all_others_foretells_them(place: int) -> None:
    model, settings = pendulum(), evidence_settings()
    windows, fit = fitted(model, [0.57, 0.60, 0.63])
    rows = blocks(windows.log, settings.block, settings.least_blocks)[place]
    rest = windows.pick(np.setdiff1d(np.arange(len(windows)), rows))
    others = Fitter(Replay(model, rest, 1), solver_settings()).run(fit.z)
    _, alone = fit_states(model, others.z, windows.pick(rows), solver_settings(), 1)
    foretold = left_out(fit, model.space, windows.log, settings)[rows]
    ours, theirs, seen = (float(np.square(r).sum()) for r in (foretold, alone.residuals, fit.residuals[rows]))
    assert theirs > 1.002 * seen  # a fit flatters the windows that it saw
    assert ours - seen == pytest.approx(theirs - seen, rel=0.25)
