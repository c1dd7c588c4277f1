"""How far from its optimum a fit may end, by the residuals that it leaves."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import pendulum, solver_settings, swinging, windows_of

from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.tolerance import Tolerance

SETTINGS = solver_settings(tolerance=1e-5, rough_tolerance=1e-3)


@pytest.mark.parametrize(("held", "share"), [(1, 1e-5), (10, 1e-4), (200, 1e-3)])
def test_so_little_evidence_is_a_larger_share_of_coloured_residuals(held: int, share: float) -> None:
    """Residuals that keep their value for `held` samples count as one; the rough tolerance is the most."""
    model = pendulum()
    replay = Replay(model, windows_of(model, [swinging("log", model.nominal(), 0)]), 1)
    point = Fitter(replay, SETTINGS).run(model.space.nominal)
    windows, samples = point.residuals.shape
    drawn = np.random.default_rng(0).standard_normal((windows, samples // held + 1))
    spoilt = replace(point, residuals=np.repeat(drawn, held, axis=1)[:, :samples], cost=1e9)
    assert Tolerance(replay, SETTINGS, rough=False).least(spoilt) == pytest.approx(1e9 * share, rel=0.5)
    assert Tolerance(replay, SETTINGS, rough=True).least(spoilt) == pytest.approx(1e9 * 1e-3)
