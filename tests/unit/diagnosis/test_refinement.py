import mujoco
import pytest

from dr_lab.diagnosis.checks.numerical_floor import numerical_floor
from dr_lab.diagnosis.checks.refinement import Refinement, refine
from dr_lab.physics.model import Model
from tests.diagnosis_machines import measured, model_check_settings, pendulum, swinging, windows_settings
from tests.element_machines import NOISE, machine, own_log
from tests.unit.diagnosis.test_numerical_floor import LOGS, swing

RK4 = mujoco.mjtIntegrator.mjINT_RK4


def refined(model: Model, logs: list, noise: float | None = None, **changes: float) -> Refinement:
    data, settings = measured(logs, noise=noise), windows_settings()
    floor = numerical_floor(model, logs, data, settings, 1)
    return refine(model, logs, data, settings, model_check_settings(**changes), floor, 1)


def test_a_fine_step_stays() -> None:
    model = swing("RK4", 0.002)
    found = refined(model, LOGS)
    assert found.model is model
    assert found.message == ""
    assert found.given == 0.002


def test_a_coarse_step_gives_way_to_the_cheapest_that_does_not_show() -> None:
    found = refined(swing("Euler", 0.01), LOGS)
    assert found.share > 1
    assert found.left <= 0.2
    assert found.given == 0.01
    option = found.model.spec.option
    assert (option.integrator, option.timestep) == (RK4, 0.01)  # four evaluations; Euler would take more than eight
    assert 'integrator "RK4"' in found.message


def test_a_finer_step_is_tried_where_the_self_test_is_left_out() -> None:
    option = refined(swing("Euler", 0.01), LOGS, windows=0).model.spec.option
    assert (option.integrator, option.timestep) == (RK4, 0.01)


def test_a_half_step_is_cheaper_where_it_is_enough() -> None:
    """Euler's error is first order: a share of 0.3 halves to 0.15."""
    model, logs = swing("Euler", 0.002), [swinging("a", pendulum().nominal(), 0)]
    first = refined(model, logs).share
    found = refined(model, logs, least_share=0.6 * first)
    assert found.model.spec.option.timestep == pytest.approx(0.001)
    assert found.model.spec.option.integrator != RK4
    assert found.left == pytest.approx(first / 2, rel=0.15)
    assert "timestep 0.001 s" in found.message


def test_the_end_of_the_search_is_told() -> None:
    """A delayed command asks for a finer step of the same integrator, and for as long a memory."""
    model = machine("motor_delay")
    found = refined(model, [own_log(model, 1)], NOISE, finest=2)
    assert found.model.spec.option.timestep == pytest.approx(0.001)
    assert found.model.spec.actuators[0].nsample == 24
    assert 0.2 < found.left < found.share
    assert "model_check.finest=2 ends the search" in found.message


def test_a_step_that_finer_steps_do_not_help_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dr_lab.diagnosis.checks.refinement._share", lambda *_: 3.0)
    model = swing("Euler", 0.01)
    found = refined(model, LOGS)
    assert found.model is model
    assert "do not take that away" in found.message
