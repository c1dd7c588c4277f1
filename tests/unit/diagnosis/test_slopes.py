"""Slopes by cheaper steps than the model's own."""

import mujoco
import numpy as np
import pytest
from diagnosis_machines import (
    PENDULUM,
    PENDULUM_PARAMETERS,
    STEP,
    model_of,
    pendulum,
    solver_settings,
    swinging,
    windows_of,
)

from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.objective import Objective
from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.slopes import around, differences, quick_around, quick_differences
from dr_lab.physics.model import Model, from_spec
from dr_lab.trajectory import Array

BOTH = np.arange(2)
# Semi-implicit Euler is stable up to a stiffness of (2/dt)² for each kg, RK4 up to (2.8/dt)².
STIFF = f"""<mujoco model="stiff"><option timestep="{STEP}" integrator="RK4" gravity="0 0 0"/><worldbody><body>
  <joint name="hinge" type="slide" axis="1 0 0" stiffness="{(2.3 / STEP) ** 2}"/><geom size="0.1" mass="1"/></body>
  </worldbody><actuator><motor name="drive" joint="hinge"/></actuator></mujoco>"""


def replay_of(model: Model, integrator: mujoco.mjtIntegrator = mujoco.mjtIntegrator.mjINT_RK4) -> Replay:
    model.spec.option.integrator = integrator
    return Replay(model, windows_of(model, [swinging("a", model.nominal(), 0)]), 1)


def start(replay: Replay, z: Array) -> Point:
    return Objective(replay, solver_settings()).point(z, np.zeros((len(replay.windows), replay.nstate)))


def test_slopes_by_cheaper_steps_are_those_of_the_model_but_for_a_few_per_cent() -> None:
    replay, settings = replay_of(pendulum()), solver_settings()
    here = start(replay, np.array([0.6, 0.1]))
    quick = quick_differences(replay, settings, here, states=True, columns=BOTH)
    exact = differences(replay, settings, here, states=True, columns=BOTH)
    off = np.linalg.norm(quick - exact, axis=(0, 1)) / np.linalg.norm(exact, axis=(0, 1))
    assert (off > 0).all()
    assert (off < 0.05).all()


def test_at_several_contexts_residuals_are_the_models_and_slopes_those_of_cheaper_steps() -> None:
    replay, settings = replay_of(pendulum()), solver_settings()
    z, delta = np.array([[0.6, 0.1], [0.5, 0.2]]), np.zeros((len(replay.windows), replay.nstate))
    residuals, _, slopes = quick_around(replay, settings, z, delta, BOTH, None)
    exact, _, _ = around(replay, settings, z, delta, BOTH, None)
    np.testing.assert_array_equal(residuals, exact)
    for each, found in zip(z, slopes, strict=True):
        one = quick_differences(replay, settings, start(replay, each), states=False, columns=BOTH)
        np.testing.assert_allclose(found, one, rtol=1e-6, atol=1e-6 * np.abs(one).max())


def test_a_model_that_is_evaluated_once_a_step_is_its_own_quick_one() -> None:
    replay = replay_of(pendulum(), mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
    assert replay.quick is replay


def test_where_cheaper_steps_diverge_slopes_are_the_models_own() -> None:
    replay, settings = replay_of(model_of(STIFF)), solver_settings()
    here = start(replay, np.zeros(0))
    assert not here.infeasible.any()
    _, lost = replay.quick.residuals(here.z[None], here.delta[None])
    assert lost.any()
    found = quick_differences(replay, settings, here, states=True, columns=np.arange(0))
    exact = differences(replay, settings, here, states=True, columns=np.arange(0))
    np.testing.assert_array_equal(found, exact)
    assert np.abs(found).max() > 0


@pytest.mark.parametrize("far", [0.3, pytest.param(2.0, marks=pytest.mark.slow)])
def test_a_fit_ends_where_it_does_by_exact_slopes(far: float, monkeypatch: pytest.MonkeyPatch) -> None:
    replay, settings = replay_of(pendulum()), solver_settings()
    z = np.array([far, 0.3])
    quick = Fitter(replay, settings).run(z)
    monkeypatch.setattr(Replay, "quick", property(lambda self: self))
    exact = Fitter(replay, settings).run(z)
    assert quick.converged
    assert quick.cost == pytest.approx(exact.cost, abs=0.05)  # 1 is what one parameter gains by chance
    np.testing.assert_allclose(quick.z, exact.z, rtol=1e-3)


@pytest.mark.parametrize("felt", [3, 10])
def test_slopes_by_free_bodies_are_those_of_a_step_of_each(felt: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A hinge feels three combinations of ten numbers; any ten that are told instead tell all ten numbers, too."""
    if felt == 10:
        every = np.linalg.qr(np.random.default_rng(3).normal(size=(10, 10)))[0]
        monkeypatch.setattr("dr_lab.diagnosis.fit.slopes.base_directions", lambda *_: every)
    parameters = {"inertial": "all", "hinge.damping": PENDULUM_PARAMETERS["hinge.damping"]}
    replay = replay_of(from_spec("pendulum", mujoco.MjSpec.from_string(PENDULUM), parameters))
    settings, unit = solver_settings(), 0.5 + 0.05 * np.random.default_rng(0).normal(size=11)
    here = start(replay, replay.model.space.from_unit(unit))
    found = differences(replay, settings, here, states=True, columns=np.arange(11))
    apart = [differences(replay, settings, here, states=True, columns=np.array([k])) for k in range(11)]
    one_by_one = np.concatenate([apart[0][..., : replay.nstate], *(each[..., replay.nstate :] for each in apart)], 2)
    off = np.linalg.norm(found - one_by_one, axis=(0, 1)) / np.linalg.norm(one_by_one, axis=(0, 1)).max()
    assert (off < 1e-3).all()
