"""Which intervals are doubted, and which parameters trade against each other."""

import numpy as np
import pytest
from diagnosis_machines import evidence_settings, model_of, pendulum, solver_settings, swinging, windows_of

from dr_lab.diagnosis.fit.covariance import estimate
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.identifiability import identifiability
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.normal_equations import NormalEquations
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.trust import at_bounds, doubts, worst_direction
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.physics.model import Model

# A force on a block: only force/mass shows, so that gear and mass trade exactly.
BLOCK = """<mujoco model="block">
  <option timestep="0.002" gravity="0 0 0" integrator="RK4"/>
  <worldbody><body name="block">
    <inertial mass="2" pos="0 0 0" diaginertia="1 1 1"/><joint name="hinge" type="slide" axis="1 0 0"/>
  </body></worldbody>
  <actuator><motor name="drive" joint="hinge" gear="1"/></actuator>
</mujoco>"""
FREE = {
    "mass": {"target": "body.block.mass", "unit": "kg", "low": 1.0, "high": 3.0},
    "gear": {"target": "actuator.drive.gear", "unit": "1", "low": 0.5, "high": 1.5},
}


def fitted(model: Model, logs: int) -> tuple[Windows, Fit]:
    windows = windows_of(model, [swinging(f"log_{k}", model.nominal(), k, seconds=1.5) for k in range(logs)])
    return windows, Fitter(Replay(model, windows, 1), solver_settings()).run(model.space.nominal)


def test_parameters_that_only_show_as_a_quotient_trade() -> None:
    model = model_of(BLOCK, FREE)
    _, fit = fitted(model, 3)
    assert worst_direction(model.space, fit) == {
        "mass": pytest.approx(np.sqrt(0.5), abs=0.02),
        "gear": pytest.approx(np.sqrt(0.5), abs=0.02),
    }


def test_few_logs_and_values_at_a_bound_are_doubted() -> None:
    model = pendulum()
    windows, fit = fitted(model, 4)
    found, settings = estimate(model.space, fit, windows, evidence_settings()), evidence_settings()
    assert set(map(tuple, doubts(found, fit, windows, settings).values())) == {()}
    at_bound = type(found)(found.space, np.array([found.space.low[0], found.mean[1]]), found.covariance)
    assert list(at_bounds(at_bound).values()) == [True, False]
    told = doubts(at_bound, fit, windows, settings)
    assert [list(reasons) for reasons in told.values()] == [["at its bound"], []]
    windows, fit = fitted(model, 2)
    few = doubts(estimate(model.space, fit, windows, settings), fit, windows, settings)
    told = "only 2 logs are fitted; from 3 on (evidence.least_trusted) their scatter is known"
    assert all(reasons == [told] for reasons in few.values())


def test_what_takes_an_effects_place_is_told() -> None:
    """Columns a, b and b/2: the second takes the place of the third, by half its width."""
    generator = np.random.default_rng(0)
    a, b = generator.normal(size=(2, 1, 200, 1))
    equations = NormalEquations.build(
        residual=np.zeros((1, 200)),
        state_jacobian=np.zeros((1, 200, 1)),
        parameter_jacobian=np.concatenate([a, b, 0.5 * b], axis=2),
        weight=np.ones((1, 200)),
        delta=np.zeros((1, 1)),
        state_precision=np.ones(1),
        prior=np.full(3, 1e-9),
        prior_gradient=np.zeros(3),
    )
    known = identifiability(equations, 1)
    np.testing.assert_allclose(np.abs(known.replacement), [0.0, 0.5], atol=1e-6)
    assert known.share < 1e-6
