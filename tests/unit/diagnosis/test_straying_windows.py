"""A window whose states end in a wrong valley outweighs all others: a fit seeks them from elsewhere before it ends."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from diagnosis_machines import pendulum, solver_settings, swinging, windows_of

from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import restarted

ASTRAY = 2  # window
FAR = 30.0  # standard deviations of the prior


@cache
def fitted() -> tuple[Fitter, Fit]:
    model = pendulum()
    logs = [swinging("log", model.compile(np.array([0.6, 0.08])), 0, seconds=3.0)]
    fitter = Fitter(Replay(model, windows_of(model, logs), 1), solver_settings())
    return fitter, fitter.run(model.space.nominal)


def astray(fitter: Fitter, fit: Fit) -> Fit:
    """The fit as it would be over with the states of one window far away."""
    delta = fit.delta.copy()
    delta[ASTRAY] += FAR * fitter.replay.windows.prior.std
    residuals, infeasible = fitter.replay.residuals(fit.z[None], delta[None])
    costs = fit.window_costs.copy()
    costs[ASTRAY] = float((residuals[0, ASTRAY] ** 2).sum())
    cost = fit.cost - fit.window_costs[ASTRAY] + costs[ASTRAY]
    ended = {"window_costs": costs, "converged": False, "over": True}
    return replace(fit, delta=delta, residuals=residuals[0], infeasible=infeasible[0], cost=cost, **ended)


def test_a_fit_that_is_over_goes_on_where_a_window_ends_lower_from_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    fitter, fit = fitted()
    descents = []

    def descend(self: Fitter, best: Point, *_: object) -> Fit:
        descents.append(best)
        return astray(fitter, fit) if len(descents) == 1 else fit

    assert astray(fitter, fit).cost > 10 * fit.cost
    monkeypatch.setattr(Fitter, "_descend", descend)
    again = fitter.run(fit.z, fit.delta)
    assert len(descents) == 2
    assert descents[1].cost == pytest.approx(fit.cost, rel=1e-3)
    assert again.cost == fit.cost


def test_a_fit_without_such_windows_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    fitter, fit = fitted()
    descents = []

    def descend(self: Fitter, best: Point, *_: object) -> Fit:
        descents.append(best)
        return replace(fit, converged=False, over=True)

    monkeypatch.setattr(Fitter, "_descend", descend)
    fitter.run(fit.z, fit.delta)
    assert len(descents) == 1


def test_only_the_windows_that_are_asked_for_change() -> None:
    fitter, fit = fitted()
    wrong = astray(fitter, fit)
    asked = np.zeros(len(fit.delta), bool)
    found = restarted(fitter.replay, fitter.settings, wrong, fit.slopes.state, asked)
    np.testing.assert_array_equal(found.delta, wrong.delta)
    asked[ASTRAY] = True
    found = restarted(fitter.replay, fitter.settings, wrong, fit.slopes.state, asked)
    others = ~asked
    np.testing.assert_array_equal(found.delta[others], wrong.delta[others])
    assert np.square(found.residuals[ASTRAY]).sum() == pytest.approx(np.square(fit.residuals[ASTRAY]).sum(), rel=0.02)
