"""Laws with a memory, and those that are not of the catalogue, against closed forms."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from plant_machines import ARM_ALONE, LOSSLESS, MOTOR, TIGHT, no_command

from dr_lab.errors import ConfigError
from dr_lab.plants.body import Body
from dr_lab.plants.command import Command
from dr_lab.plants.drive import ForceDrive
from dr_lab.plants.hidden.actuator_lag import ActuatorLag
from dr_lab.plants.hidden.bending_friction import BendingFriction
from dr_lab.plants.hidden.coasting_bridge import CoastingBridge
from dr_lab.plants.hidden.command_power import CommandPower
from dr_lab.plants.hidden.constant_offset import ConstantOffset
from dr_lab.plants.hidden.creeping_friction import CreepingFriction
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.hidden.encoder_eccentricity import EncoderEccentricity
from dr_lab.plants.hidden.end_stop import EndStop
from dr_lab.plants.hidden.force_limit import ForceLimit
from dr_lab.plants.hidden.hysteresis import Hysteresis
from dr_lab.plants.hidden.joint_elasticity import JointElasticity
from dr_lab.plants.hidden.load_dependent_friction import LoadDependentFriction
from dr_lab.plants.hidden.lugre_friction import LugreFriction
from dr_lab.plants.hidden.motor_side_elasticity import MotorSideElasticity
from dr_lab.plants.hidden.position_dependent_friction import PositionDependentFriction
from dr_lab.plants.hidden.rate_limit import RateLimit
from dr_lab.plants.hidden.sensor_bias import SensorBias
from dr_lab.plants.hidden.sensor_drift import SensorDrift
from dr_lab.plants.hidden.sensor_low_pass import SensorLowPass
from dr_lab.plants.hidden.sensor_scale import SensorScale
from dr_lab.plants.hidden.several import Several
from dr_lab.plants.hidden.torque_speed_limit import TorqueSpeedLimit
from dr_lab.plants.hidden.velocity_low_pass import VelocityLowPass
from dr_lab.plants.hidden.voltage_sag import VoltageSag
from dr_lab.plants.motion import simulate
from dr_lab.plants.mujoco_machine import MujocoMachine
from dr_lab.trajectory import Array

FREE = replace(ARM_ALONE, drives=(ForceDrive(),))  # an arm that turns alone, a torque in
INERTIA = FREE.mass((0.0, 0.0))[0][0]
TIME = np.linspace(0.0, 0.4, 81)


SERVO = """<mujoco><worldbody><body name="arm"><joint name="arm" axis="0 0 1" armature="0.02"/>
  <inertial pos="0 0 0" mass="0.5" diaginertia="0.004 0.004 0.004"/></body></worldbody>
  <actuator><position name="servo" joint="arm" kp="6" kv="0.15"/></actuator></mujoco>"""


def moved(effect: HiddenEffect, command: Command | None = None, speed: float = 0.0) -> Array:
    """States of the free arm from rest, or from a speed in rad/s."""
    start = (0.0, 0.0, speed, 0.0)
    return simulate(FREE, effect, [command or no_command()], TIME, accuracy=TIGHT, start=start)


def test_a_lag_is_an_exponential() -> None:
    constant, torque = 0.05, 1e-4
    states = moved(ActuatorLag(constant), Command(np.array([0.0]), np.array([torque])))
    expected = torque / INERTIA * (TIME - constant * (1 - np.exp(-TIME / constant)))
    np.testing.assert_allclose(states[:, 2], expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(states[:, 4], torque * (1 - np.exp(-TIME / constant)), rtol=0, atol=1e-12)


def test_a_limited_rate_is_a_ramp() -> None:
    torque, rate = 1e-4, 1e-3  # full after 0.1 s
    states = moved(RateLimit(rate, settling=1e-4), Command(np.array([0.0]), np.array([torque])))
    np.testing.assert_allclose(states[:, 4], np.minimum(rate * TIME, torque), rtol=0, atol=2e-7)


def test_lugre_bristles_bend_like_a_spring_then_slide_as_stribeck_says() -> None:
    law = LugreFriction("arm", coulomb=1e-4, static=2e-4, speed=0.5, stiffness=0.05, damping=0.0)
    (bristle,) = law.memories()
    assert bristle.force(1e-4, 0.0, 0.0) == pytest.approx(-0.05 * 1e-4)
    assert bristle.rate(1e-4, 0.0) == 0.0
    for speed in (0.1, -0.5, 3.0):
        steady = math.copysign(1e-4 + 1e-4 * math.exp(-((speed / 0.5) ** 2)), speed)
        assert bristle.rate(steady / 0.05, speed) == pytest.approx(0.0, abs=1e-15)
    # In motion: a driven arm whose friction has settled gains speed by what friction leaves.
    pushed = Several({"a": law, "b": ConstantOffset("arm", 4e-4)})
    states = moved(pushed, speed=5.0)
    np.testing.assert_allclose(np.diff(states[20:, 2]) / np.diff(TIME[20:]), (4e-4 - 1e-4) / INERTIA, rtol=1e-6)


def test_bending_friction_is_lugre_without_a_drop() -> None:
    (plain,) = BendingFriction("arm", torque=2e-4, stiffness=0.05, damping=1e-3).memories()
    (lugre,) = LugreFriction("arm", 2e-4, 2e-4, 0.5, 0.05, 1e-3).memories()
    for bent, speed in ((1e-3, 0.2), (-2e-3, 0.4), (4e-3, -1.0), (0.0, 3.0)):
        rate = plain.rate(bent, speed)
        assert rate == pytest.approx(lugre.rate(bent, speed))
        assert plain.force(bent, rate, speed) == pytest.approx(lugre.force(bent, rate, speed))
    assert plain.rate(2e-4 / 0.05, 0.7) == pytest.approx(0.0, abs=1e-15)  # fully bent while it slides


def test_dahls_spring_yields_exponentially_with_the_way() -> None:
    law = Hysteresis("arm", torque=1e-3, displacement=0.2)
    (bristle,) = law.memories()
    heavy = replace(FREE, armature=(1e6, 1.0))
    states = simulate(heavy, law, [no_command()], TIME, accuracy=TIGHT, start=(0.0, 0.0, 1.0, 0.0))
    bent = states[:, 4]
    np.testing.assert_allclose(bent, 0.2 * (1 - np.exp(-states[:, 0] / 0.2)), rtol=0, atol=1e-9)
    assert bristle.force(0.2, 0.0, 1.0) == pytest.approx(-1e-3)


def test_tanh_friction_decays_as_its_closed_form() -> None:
    torque, creep, speed = 1e-4, 0.3, 2.0
    states = moved(CreepingFriction("arm", torque, creep), speed=speed)
    # d(sinh(v/c))/dt = −(T / (I c)) sinh(v/c)
    expected = creep * np.arcsinh(np.sinh(speed / creep) * np.exp(-torque / (INERTIA * creep) * TIME))
    np.testing.assert_allclose(states[:, 2], expected, rtol=0, atol=1e-8)


def test_a_filtered_encoder_lags_behind_even_motion_by_its_constant() -> None:
    time = np.linspace(0.0, 1.0, 51)
    effect = SensorLowPass("arm", 0.02)
    states = simulate(LOSSLESS, effect, [no_command()], time, accuracy=TIGHT, start=(0.0, 0.0, 0.0, 0.0))
    assert Body.of(LOSSLESS, effect).read_columns == (4, 1)
    assert not states.any()
    states = moved(effect, speed=3.0)
    late = states[:, 0] - 3.0 * 0.02 * (1 - np.exp(-TIME / 0.02))
    np.testing.assert_allclose(states[:, 4], late, rtol=0, atol=1e-9)


def test_a_filtered_tachometer_lags_behind_even_acceleration_by_its_constant() -> None:
    effect, torque, constant = VelocityLowPass("arm", 0.02), 1e-4, 0.02
    states = moved(effect, Command(np.array([0.0]), np.array([torque])), speed=3.0)
    body = Body.of(FREE, effect)
    assert body.read_columns == (0, 1)
    assert body.velocity_columns == (4, 3)
    np.testing.assert_allclose(states[:, 2], 3.0 + torque / INERTIA * TIME, rtol=0, atol=1e-9)
    late = states[:, 2] - torque / INERTIA * constant * (1 - np.exp(-TIME / constant))
    np.testing.assert_allclose(states[:, 4], late, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (ActuatorLag(0.02), ActuatorLag(0.05)),
        (ActuatorLag(0.02), RateLimit(1e-3, settling=1e-4)),
        (SensorLowPass("arm", 0.02), SensorLowPass("arm", 0.01)),
        (VelocityLowPass("arm", 0.02), VelocityLowPass("arm", 0.01)),
    ],
)
def test_two_memories_of_a_kind_at_one_place_are_refused(first: HiddenEffect, second: HiddenEffect) -> None:
    with pytest.raises(ConfigError, match="two memories of a kind at one place"):
        Body.of(FREE, Several({"a": first, "b": second}))


def test_bristles_at_one_joint_add_up() -> None:
    torque, way = 1e-4, 0.05
    half, whole = Hysteresis("arm", torque / 2, way), Hysteresis("arm", torque, way)
    both = moved(Several({"a": half, "b": half}), speed=3.0)
    np.testing.assert_allclose(both[:, :2], moved(whole, speed=3.0)[:, :2], rtol=0, atol=1e-9)


def test_an_encoder_at_the_motor_shows_the_motor() -> None:
    effect = MotorSideElasticity("arm", rotor=1e-4, compliance=100.0, damping=0.0)
    assert Body.of(replace(FREE, armature=(1e-3, 1.0)), effect).read_columns == (2, 1)


def test_a_motor_behind_a_spring_has_the_feedback_of_its_own_motion() -> None:
    geared = JointElasticity("arm", rotor=1e-6, compliance=1.0, damping=0.0)
    blocked = Body.of(replace(ARM_ALONE, drives=(MOTOR,)), geared)
    idle = 5.0 / MOTOR.constant  # rad/s, where the back-EMF is the voltage
    _, force = blocked.terms(0.0, [0.0] * 3, [0.0, 0.0, idle], [5.0], [0.0] * 3)
    assert force[2] == pytest.approx(0.0, abs=1e-12)
    model = mujoco.MjModel.from_xml_string(SERVO)
    held = Body.of(MujocoMachine.of(model), JointElasticity("arm", rotor=0.01, compliance=1.0, damping=0.0))
    _, force = held.terms(0.0, [0.3, 0.8], [0.0, 2.0], [1.0], [0.0, 0.0])
    assert force == pytest.approx([0.5, 6 * (1.0 - 0.8) - 0.15 * 2.0 - 0.5])


def test_readings_commands_and_forces_follow_their_formulas() -> None:
    time, q = np.array([0.0, 2.0]), np.array([0.5, -1.0])
    eccentric = EncoderEccentricity("arm", 0.02, -0.01)
    np.testing.assert_allclose(eccentric.reading("arm", time, q), q + 0.02 * np.sin(q) - 0.01 * np.cos(q))
    assert eccentric.reading("pole", time, q) == pytest.approx(q)
    geared = EncoderEccentricity("arm", 0.02, -0.01, periods=6.0)
    error = 0.02 * np.sin(6 * q) - 0.01 * np.cos(6 * q)  # of a disc that turns six times as far
    np.testing.assert_allclose(geared.reading("arm", time, q), q + error / 6, rtol=1e-12)
    both = Several({"a": SensorScale("arm", 0.1), "b": SensorDrift("arm", 0.3)})
    np.testing.assert_allclose(both.reading("arm", time, q), 1.1 * q + 0.3 * time)
    assert both.label == "sensor_scale@arm + sensor_drift@arm"
    bias, scale = SensorBias("arm", 0.2), SensorScale("arm", 0.1)
    np.testing.assert_allclose(Several({"a": bias, "b": scale}).reading("arm", time, q), 1.1 * (q + 0.2))
    np.testing.assert_allclose(Several({"a": scale, "b": bias}).reading("arm", time, q), 1.1 * q + 0.2)
    sent = Command(np.array([0.0, 1.0]), np.array([2.0, -4.0]))
    np.testing.assert_allclose(VoltageSag(0.05).command("motor", sent).value, [1.8, -3.2])
    np.testing.assert_allclose(CommandPower(4.0).command("motor", sent).value, [1.0, -4.0])
    np.testing.assert_allclose(CommandPower(4.0, 0.5).command("motor", sent).value, [math.sqrt(8.0), -4.0])
    stop = EndStop("arm", -1.0, 0.4, stiffness=10.0, loss=0.5)
    assert stop.force(0.0, 0.3, 5.0) == 0.0
    assert stop.force(0.0, 0.5, 0.4) == pytest.approx(-10.0 * 0.1 * 1.2)
    assert stop.force(0.0, -1.2, 100.0) == 0.0  # it pushes and never pulls
    worn = PositionDependentFriction("arm", 2.0, 0.5, 0.0, creep=1e-3)
    assert worn.force(0.0, math.pi / 2, -1.0) == pytest.approx(3.0)


def test_gears_and_motors_under_load() -> None:
    gear = LoadDependentFriction("lift", share=0.1, creep=1e-3)
    assert gear._added(50.0, -30.0, 0.5) == pytest.approx(-8.0)
    limit = TorqueSpeedLimit("lift", stall=10.0, free=4.0)
    assert [limit._added(8.0, 0.0, v) for v in (0.0, 2.0, -2.0)] == pytest.approx([0.0, -3.0, 0.0])
    assert limit._added(-8.0, 0.0, 5.0) == pytest.approx(0.0)
    assert limit._added(8.0, 0.0, 5.0) == pytest.approx(-10.5)
    servo = ForceLimit("lift", limit=10.0)
    assert [servo._added(f, -30.0, 2.0) for f in (8.0, 14.0, -14.0)] == [0.0, -4.0, 4.0]
    coasting = CoastingBridge("lift", free=4.0)
    assert [coasting._added(f, -30.0, v) for f, v in ((8.0, 2.0), (-8.0, 2.0), (8.0, 0.0))] == [-4.0, -4.0, 0.0]
