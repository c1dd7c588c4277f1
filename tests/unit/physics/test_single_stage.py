import mujoco
import numpy as np
import pytest
from diagnosis_machines import pendulum

from dr_lab.physics.model import Model
from dr_lab.physics.single_stage import single_stage


def with_integrator(integrator: mujoco.mjtIntegrator) -> Model:
    model = pendulum()
    model.spec.option.integrator = integrator
    return model


@pytest.mark.parametrize(
    "integrator",
    [
        mujoco.mjtIntegrator.mjINT_EULER,
        mujoco.mjtIntegrator.mjINT_IMPLICIT,
        mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    ],
)
def test_a_model_that_is_evaluated_once_a_step_stays_as_it_is(integrator: mujoco.mjtIntegrator) -> None:
    model = with_integrator(integrator)
    assert single_stage(model) is model


def test_a_runge_kutta_step_becomes_one_of_euler_and_nothing_else_changes() -> None:
    model = with_integrator(mujoco.mjtIntegrator.mjINT_RK4)
    before = model.spec.to_xml()
    quick = single_stage(model)
    assert quick.compile(np.array([0.6, 0.1])).opt.integrator == mujoco.mjtIntegrator.mjINT_EULER
    assert model.spec.to_xml() == before
    quick.spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    assert quick.spec.to_xml() == before
