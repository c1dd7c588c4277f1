import mujoco
import numpy as np
import pytest

from dr_lab.diagnosis.checks.self_test import require_own_logs_explained
from dr_lab.errors import ModelError
from dr_lab.physics.model import Model
from dr_lab.trajectory import Log, MeasurementSet
from tests.diagnosis_machines import measured, model_check_settings, model_of, solver_settings, windows_settings
from tests.element_machines import NAMES, NOISE, machine, own_log

LATE = """<mujoco model="late"><compiler angle="radian"/><option timestep="0.002" integrator="implicitfast"/>
  <worldbody><body name="rod"><inertial mass="0.5" pos="0 0 -0.3" diaginertia="0.005 0.005 0.001"/>
    <joint name="hinge" axis="0 1 0" damping="0.05"/></body></worldbody>
  <actuator><motor name="drive" joint="hinge"/></actuator>
  <sensor><jointpos name="encoder" joint="hinge" delay="{delay}" nsample="40"/></sensor></mujoco>"""


def tried(model: Model, data: MeasurementSet, **changes: float) -> dict[str, float]:
    check = model_check_settings(**changes)
    return require_own_logs_explained(model, data, windows_settings(), solver_settings(), check)


@pytest.mark.parametrize("name", NAMES)
def test_a_model_of_any_element_explains_its_own_logs(name: str) -> None:
    model = machine(name)
    found = tried(model, measured([own_log(model, 1)], noise=NOISE))
    assert found
    assert max(found.values()) <= 1.1


def late(delay: float) -> tuple[Model, MeasurementSet]:
    """A pendulum whose encoder is late inside the MJCF."""
    model = model_of(LATE.format(delay=delay))
    log = own_log(model, 1)
    reading = log.outputs["hinge.position"]
    named = {"sensor.encoder": type(reading)("sensor.encoder", "rad", reading.time, reading.value)}
    return model, measured([Log("a", named | {"hinge.position": reading}, log.commands)], noise=NOISE)


def test_late_sensors_remember_what_they_read_before_a_window() -> None:
    found = tried(*late(0.06))  # three times as late as windows are simulated before their samples
    assert max(found.values()) <= 1.15


def test_a_state_that_no_window_restores_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dr_lab.physics.simulator.remember_readings", lambda *state: None)
    model, data = late(0.06)
    with pytest.raises(
        ModelError, match=r"'late' does not explain logs that it made itself: .*sensor\.encoder"
    ) as told:
        tried(model, data)
    assert "delay of sensor" in str(told.value)
    assert "encoder. Take such elements out" in str(told.value)
    assert tried(model, data, windows=0) == {}


def test_activations_that_are_not_restored_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    model = machine("position_timeconst")
    data = measured([own_log(model, 1)], noise=NOISE)
    monkeypatch.setattr(
        "dr_lab.diagnosis.windows.run_in.RunIn.ends", lambda self, z: np.zeros((len(z), *np.shape(self._begin)))
    )
    monkeypatch.setattr(
        "dr_lab.diagnosis.windows.activations.resting", lambda model, qpos, controls: np.zeros((len(qpos), 1))
    )
    with pytest.raises(ModelError, match="activation of actuator drive"):
        tried(model, data)


def test_logs_shorter_than_the_lead_are_tried_without() -> None:
    model = machine("motor")
    found = tried(model, measured([own_log(model, 1, seconds=0.5)], noise=NOISE))
    assert found["hinge.position"] == pytest.approx(1.0, abs=0.2)


def test_a_model_that_diverges_everywhere_is_left_to_the_numerical_floor() -> None:
    spec = mujoco.MjSpec.from_string(LATE.format(delay=0.0).replace('damping="0.05"', 'damping="400"'))
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    data = measured([own_log(machine("motor"), 1)], noise=NOISE)
    assert tried(Model("stiff", spec, (), {}), data) == {}
