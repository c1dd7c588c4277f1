import numpy as np
import pytest
from diagnosis_machines import NOISE, measured, model_of, pendulum, swinging, windows_settings

from dr_lab.diagnosis.checks.numerical_floor import NumericalFloor, numerical_floor
from dr_lab.errors import ModelError
from dr_lab.physics.model import Model

LOGS = [swinging("a", pendulum().nominal(), 0)]


def swing(integrator: str, timestep: float, damping: float = 0.05) -> Model:
    return model_of(f"""<mujoco model="swing">
      <option timestep="{timestep}" integrator="{integrator}"><flag eulerdamp="disable"/></option>
      <worldbody><body><inertial mass="0.5" pos="0 0 -0.3" diaginertia="0.005 0.005 0.001"/>
        <joint name="hinge" axis="0 1 0" damping="{damping}"/></body></worldbody>
      <actuator><motor name="drive" joint="hinge"/></actuator></mujoco>""")


def floor(model: Model) -> NumericalFloor:
    return numerical_floor(model, LOGS, measured(LOGS), windows_settings(), 1)


def test_a_fine_step_is_left_alone() -> None:
    found = floor(swing("RK4", 0.002))
    assert found.share["hinge.position"] < 1e-3
    assert found.proposed == found.step == 0.002


def test_a_coarse_step_is_flagged_and_a_finer_one_proposed() -> None:
    found = floor(swing("Euler", 0.01))
    assert found.share["hinge.position"] > 1
    assert found.error["hinge.position"] == pytest.approx(found.share["hinge.position"] * NOISE)
    assert found.proposed == pytest.approx(0.0025)


def test_a_first_order_error_halves_with_the_step() -> None:
    coarse, fine = (floor(swing("Euler", step)).error["hinge.position"] for step in (0.008, 0.004))
    assert coarse / fine == pytest.approx(2.0, rel=0.1)


def test_a_step_at_which_nothing_can_be_simulated_is_an_error() -> None:
    # explicit damping is stable up to a step of 2·inertia/damping, 0.05 kg·m² / 40 N·m·s/rad
    with pytest.raises(ModelError, match=r"diverges in every window .*timestep 0\.0025"):
        floor(swing("Euler", 0.01, damping=40.0))
    assert np.isfinite(floor(swing("Euler", 0.002, damping=40.0)).share["hinge.position"])
