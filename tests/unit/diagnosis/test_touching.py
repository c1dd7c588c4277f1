"""A pendulum that swings against a wall: slopes are taken by wide steps, and its mass is found through the impacts."""

import numpy as np
import pytest
from diagnosis_machines import PENDULUM, PENDULUM_PARAMETERS, model_of, solver_settings, swinging, windows_of

from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.slopes import differences
from dr_lab.diagnosis.fit.states import StateFit, _Search, fit_states
from dr_lab.physics.model import Model

TRUTH = np.array([0.6, 0.08])


def walled(away: float, kind: int = 1) -> Model:
    """The pendulum with a ball at its end, and a wall whose near side is so many metres away."""
    ball = f'<geom type="sphere" size="0.03" pos="0 0 -0.3" mass="0" contype="{kind}" conaffinity="{kind}"/>'
    wall = f'<geom type="box" size="0.1 0.1 0.5" pos="{away + 0.1} 0 -0.3"/>'
    xml = PENDULUM.replace("</body></worldbody>", f"{ball}</body>{wall}</worldbody>")
    return model_of(xml, PENDULUM_PARAMETERS)


def replayed(model: Model) -> Replay:
    return Replay(model, windows_of(model, [swinging(f"log_{k}", model.compile(TRUTH), k) for k in range(2)]), 1)


@pytest.mark.parametrize(("away", "kind", "touches"), [(0.05, 1, True), (0.05, 0, False), (0.5, 1, False)])
def test_what_touches_is_told(away: float, kind: int, touches: bool) -> None:
    replay = replayed(walled(away, kind))
    assert replay.touching == touches
    assert replay.part(np.arange(2)).touching == touches  # also where these two windows alone do not
    assert replay.quick.touching == touches


def test_slopes_are_taken_by_wider_steps_where_shapes_touch() -> None:
    replay, settings = replayed(walled(0.05)), solver_settings()
    fitter = Fitter(replay, settings)
    point, columns = fitter.begin(TRUTH, np.zeros((len(replay.windows), replay.nstate))), np.arange(2)
    unit = replay.model.space.to_unit(point.z)
    wide = settings.touching * settings.parameter_step
    moved = np.stack([unit + wide * row for row in np.eye(2)])  # both lie in the lower half of their bounds
    found, _ = replay.residuals(replay.model.space.from_unit(moved), np.tile(point.delta, (2, 1, 1)))
    slopes = differences(replay, settings, point, states=False, columns=columns)
    np.testing.assert_allclose(slopes, (found - point.residuals).transpose(1, 2, 0) / wide, atol=1e-6)


def test_a_mass_is_found_through_impacts() -> None:
    replay = replayed(walled(0.05))
    fit = Fitter(replay, solver_settings()).run(replay.model.space.nominal)
    assert fit.cost / replay.fitted.sum() < 1.5
    np.testing.assert_allclose(fit.z, TRUTH, rtol=0.03)


def test_a_start_that_is_stuck_among_contacts_is_drawn_anew() -> None:
    """A window of which the search ended 3 standard deviations off."""
    model = walled(0.05)
    replay, fit = fit_states(model, TRUTH, replayed(model).windows, solver_settings(), 1)
    search = _Search(replay, solver_settings(), TRUTH)
    off = fit.delta.copy()
    off[0] += 3.0 * replay.windows.prior.std
    stuck = search.point(off)
    before = StateFit(stuck.z, stuck.delta, stuck.residuals, stuck.cost, stuck.infeasible, fit.slopes)
    after = search._drawn(before)
    left, expected = (search._left(each) for each in (after, fit))
    assert search._left(before)[0] > 10.0 * expected[0]
    assert left[0] == pytest.approx(expected[0], rel=0.01)
    np.testing.assert_array_equal(after.delta[1:], before.delta[1:])
