"""A fit of all ten inertial parameters of a body, of which one hinge tells three combinations."""

from functools import cache

import mujoco
import numpy as np
import pytest
from diagnosis_machines import PENDULUM, evidence_settings, solver_settings, swinging, windows_of
from effect_machines import scales_of

from dr_lab.comparison.inertia import inertia_entry
from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fit_and_score
from dr_lab.diagnosis.fit.base_parameters import BaseParameters, base_parameters
from dr_lab.diagnosis.fit.covariance import estimate
from dr_lab.diagnosis.fit.prior import prior_precision
from dr_lab.diagnosis.missing_force.force_step import Course, Learned, Machine
from dr_lab.physics.model import Model, from_spec
from dr_lab.physics.radial_basis import Input, around, features
from dr_lab.trajectory import Array

TRUTH = PENDULUM.replace('mass="0.5" pos="0 0 -0.3"', 'mass="0.6" pos="0.01 0.008 -0.28"')


def model() -> Model:
    return from_spec("pendulum", mujoco.MjSpec.from_string(PENDULUM), "inertial")


@cache
def bench() -> Bench:
    compiled = mujoco.MjSpec.from_string(TRUTH).compile()
    fit, scored = ([swinging(f"log_{seed}", compiled, seed) for seed in seeds] for seeds in ((1, 2, 3), (4,)))
    return Bench(windows_of(model(), fit), windows_of(model(), scored), solver_settings(), evidence_settings(), 1)


@cache
def fitted() -> FittedModel:
    return fit_and_score(bench(), model(), model().space.nominal)


def felt(compiled: mujoco.MjModel) -> Array:
    """Inertia about the hinge and the two first moments across it."""
    body = compiled.body("rod")
    data = mujoco.MjData(compiled)
    mujoco.mj_forward(compiled, data)
    moment = float(body.mass[0]) * body.ipos
    return np.array([compiled.dof_M0[0], moment[0], moment[2]])


def known() -> BaseParameters:
    return base_parameters(fitted().fit.equations, fitted().model.space.names, np.arange(10))


@pytest.mark.slow
def test_what_the_hinge_feels_is_recovered() -> None:
    found = felt(fitted().model.compile(fitted().fit.z))
    np.testing.assert_allclose(found, felt(mujoco.MjSpec.from_string(TRUTH).compile()), rtol=5e-3, atol=5e-4)
    assert fitted().held_out.chi2 < 1.1


@pytest.mark.slow
def test_the_logs_know_three_of_ten_combinations() -> None:
    base = known()
    assert (base.count, base.rank, base.known) == (10, 3, 3)
    assert len(base.chosen) == 3
    assert {f"rod.inertial.{name}" for name in ("shift_y", "stretch_y", "shear_xy")} <= set(base.held)


@pytest.mark.slow
def test_what_they_do_not_know_stays_at_the_model_file() -> None:
    """Of all bodies that move alike, the fit ends with the one that is nearest to the nominal one."""
    z, space = fitted().fit.z, fitted().model.space
    information = fitted().fit.equations.window_information()[0].sum(0)
    values, vectors = np.linalg.eigh(information)
    unknown = vectors[:, :5]  # of seven, five to the last digit: a step that is far changes the others a little
    assert values[6] < 1e-4 * values[7]
    prior = prior_precision(space, solver_settings())
    pull, stiffness = unknown.T @ (prior * z / space.span), unknown.T @ np.diag(prior) @ unknown
    left = float(pull @ np.linalg.solve(stiffness, pull))  # what a step to the nearest one would lower the cost by
    assert left < solver_settings().tolerance  # where a fit ends; cost and deviance are alike at the noise floor
    assert (np.abs(z) < 0.9 * space.high).all()


@pytest.mark.slow
def test_the_report_tells_the_bodies_mass_with_its_doubt() -> None:
    one = fitted()
    found = estimate(one.model.space, one.fit, bench().fit, evidence_settings())
    entry = inertia_entry(one, found)
    assert entry is not None
    body = entry.bodies["rod"]
    assert body.mass == pytest.approx(float(one.model.compile(one.fit.z).body("rod").mass[0]))
    assert body.mass_std is not None
    assert body.mass_std > 0.01  # the hinge feels moments, not the mass
    assert abs((body.mass or 0.0) - 0.6) < 3 * body.mass_std


def test_a_force_is_learned_beside_the_bodies_own_priors() -> None:
    space, scales = fitted().model.space, scales_of(model(), torque=1.0, position=2.0, speed=1.0)
    machine = Machine(bench(), model().nominal(), scales, "hinge", most=2.0)
    course = Course(machine, Learned(fitted().model, fitted().fit, np.zeros(0), space.names), parts=4)
    inputs = (Input("angle", "hinge", 0.5),)
    basis = around(inputs, features(inputs, machine.compiled, course.seen), 5, 1.0)
    linear = course.linear(basis, np.zeros(len(basis.centres)))
    np.testing.assert_allclose(linear.prior, prior_precision(space, solver_settings()))
    np.testing.assert_allclose(linear.prior_gradient, fitted().fit.equations.prior_gradient)
