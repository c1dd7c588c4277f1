"""A motor that turns apart from its link: two masses on a spring, and teeth across a gap, against closed forms."""

from collections.abc import Mapping

import mujoco
import numpy as np
import pytest
from effect_machines import block, placed, scales_of

from dr_lab.effects.joint_drive import JointDrive
from dr_lab.physics.law import History
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

MASS, ROTOR, FORCE = 2.0, 0.5, 4.0  # kg of both, kg of them with the motor, N
STEP, SECONDS = 0.002, 0.6
LINK = MASS - ROTOR
AMID = 200  # steps that were measured before


def pushed(name: str, before: float, values: Mapping[str, float], speeding: float = 0.0) -> tuple[Array, Array]:
    """Times, and places of the link under a force, after it was seen under another one with some acceleration."""
    model = block()
    extended = model.with_effect(placed(model, name, "rail"))
    z = extended.space.vector({f"{name}@rail.{key}": value for key, value in values.items()})
    speed = (speeding * STEP * (np.arange(-AMID, 0.0) + 0.5))[None, :, None]
    history = History(np.zeros(1), np.zeros((1, AMID, 1)), speed, np.full((1, AMID, 1), before))
    controls, rest = np.full((1, round(SECONDS / STEP), 1), FORCE), np.zeros((1, 1, 1))
    rollout = Simulator(extended, 1, threads=1).replay(z[None], rest, rest, controls, controls[:, :1], history)
    return np.arange(rollout.qpos.shape[1]) * STEP, rollout.qpos[0, :, 0]


def spring(frequency: float, rotor: float = ROTOR, retardation: float = 1e-9) -> dict[str, float]:
    """Values for ω² = (1/J + 1/J_link)/C."""
    return {"compliance": (1 / rotor + 1 / (MASS - rotor)) / frequency**2, "rotor": rotor, "retardation": retardation}


@pytest.mark.parametrize("rotor", [0.02, ROTOR, 1.6])
def test_two_masses_swing_at_their_frequency(rotor: float) -> None:
    """A step of the force winds the spring by d = F C J_link/M (1 − cos ωt); the centre of mass does not know of it."""
    frequency = 40.0
    values = spring(frequency, rotor)
    time, place = pushed("joint_elasticity", 0.0, values)
    twist = FORCE * values["compliance"] * (MASS - rotor) / MASS
    behind = rotor / MASS * twist * (1 - np.cos(frequency * time))
    expected = 0.5 * FORCE / MASS * time**2 - behind
    np.testing.assert_allclose(place, expected, rtol=0, atol=0.03 * behind.max())


def test_a_damped_spring_comes_to_rest() -> None:
    values = spring(40.0, retardation=0.02)
    time, place = pushed("joint_elasticity", 0.0, values)
    behind = ROTOR / MASS * FORCE * values["compliance"] * LINK / MASS
    np.testing.assert_allclose(place[-20:], (0.5 * FORCE / MASS * time**2 - behind)[-20:], rtol=0, atol=1e-3 * behind)


@pytest.mark.parametrize("compliance", [1e-12, 1e-9, 1e-7])
@pytest.mark.parametrize("rotor", [0.02, 1.6])
@pytest.mark.parametrize("name", ["joint_elasticity", "motor_side_elasticity"])
def test_a_stiff_spring_is_none(name: str, compliance: float, rotor: float) -> None:
    """The rotor's inertia is then the joint's armature."""
    values = {"compliance": compliance, "rotor": rotor, "retardation": 2e-3}
    time, place = pushed(name, 0.0, values)
    np.testing.assert_allclose(place, 0.5 * FORCE / MASS * time**2, rtol=0, atol=max(FORCE * compliance, 1e-12))


def test_what_was_measured_before_has_wound_the_spring() -> None:
    """Where force and acceleration were steady nothing swings."""
    time, place = pushed("joint_elasticity", FORCE, spring(40.0, retardation=0.02), speeding=FORCE / MASS)
    np.testing.assert_allclose(place, 0.5 * FORCE / MASS * time**2, rtol=0, atol=5e-5)


@pytest.mark.parametrize("rotor", [0.02, ROTOR, 1.6])
def test_an_encoder_at_the_motor_reads_the_motor(rotor: float) -> None:
    """It is ahead of the centre of mass by J_link/M of the twist, as the link is behind by J/M of it."""
    frequency = 40.0
    values = spring(frequency, rotor)
    time, place = pushed("motor_side_elasticity", 0.0, values)
    link = (MASS - rotor) / MASS
    ahead = link * FORCE * values["compliance"] * link * (1 - np.cos(frequency * time))
    expected = 0.5 * FORCE / MASS * time**2 + ahead
    np.testing.assert_allclose(place, expected, rtol=0, atol=0.03 * ahead.max())


def test_a_window_begins_where_the_motor_was_seen() -> None:
    """Where force and acceleration were steady the spring is wound, and nothing swings."""
    values = spring(40.0, retardation=0.02)
    time, place = pushed("motor_side_elasticity", FORCE, values, speeding=FORCE / MASS)
    np.testing.assert_allclose(place, 0.5 * FORCE / MASS * time**2, rtol=0, atol=5e-5)


@pytest.mark.parametrize("gap", [0.002, 0.02, 0.1])
def test_the_motors_way_is_the_gap(gap: float) -> None:
    """The link rests while the motor flies √(2 J gap/F); then both move, and J/M of the gap is missing in its way."""
    time, place = pushed("backlash", -FORCE, {"gap": gap, "rotor": ROTOR})
    flight = np.sqrt(2 * ROTOR * gap / FORCE)
    assert np.abs(place[time < flight - 2 * STEP]).max(initial=0.0) < 1e-12
    settled = time > flight + 20 * STEP
    missing = 0.5 * FORCE / MASS * time**2 - place
    np.testing.assert_allclose(missing[settled], ROTOR / MASS * gap, rtol=1e-6)


def test_teeth_in_contact_are_rigid() -> None:
    time, place = pushed("backlash", FORCE, {"gap": 0.02, "rotor": ROTOR})
    np.testing.assert_allclose(place, 0.5 * FORCE / MASS * time**2, rtol=0, atol=1e-12)


def drive(actuator: str, joint: str = "") -> tuple[Model, JointDrive]:
    model = block(actuator, joint)
    return model, JointDrive.of([model.nominal()], "rail")


def test_a_drive_is_what_its_actuators_give() -> None:
    _, motor = drive('<motor name="drive" joint="rail" gear="3"/>')
    at = np.array([[0.2]]), np.array([[0.5]]), np.array([[2.0]])
    np.testing.assert_allclose(motor.force(*at), [6.0], rtol=1e-9)
    _, servo = drive('<position name="drive" joint="rail" kp="10" kv="2"/>')
    np.testing.assert_allclose(servo.force(*at), [10 * (2.0 - 0.2) - 2 * 0.5], rtol=1e-9)


def test_a_drive_ends_at_its_actuators_force_limits() -> None:
    at = np.zeros((3, 1)), np.zeros((3, 1)), np.array([[-9.0], [0.5], [9.0]])
    limited = '<motor name="drive" joint="rail" gear="-2" forcerange="-1 3"/>'
    _, motor = drive(limited)
    np.testing.assert_allclose(motor.force(*at), [2.0, -1.0, -6.0], rtol=1e-9)
    _, both = drive(limited + '<position name="hold" joint="rail" kp="10" ctrlrange="-1 1" forcerange="-5 5"/>')
    assert (both.low[0], both.high[0]) == (-11.0, 7.0)
    _, one = drive(limited + '<damper name="brake" joint="rail" ctrlrange="0 1"/>')
    assert (one.low[0], one.high[0]) == (-np.inf, np.inf)


@pytest.mark.parametrize(
    ("actuator", "joint"),
    [
        ('<position name="drive" joint="rail" kp="100" kv="10" ctrlrange="-3 -0.5"/>', ""),
        ('<position name="drive" joint="rail" kp="100" kv="10" ctrlrange="-3 -0.5" forcerange="-20 20"/>', ""),
        ('<motor name="drive" joint="rail" gear="5" ctrlrange="0.2 1"/>', ""),
        ('<motor name="drive" joint="rail" gear="5"/>', 'actuatorfrcrange="-3 4"'),
        ('<general name="drive" joint="rail" gainprm="5" dyntype="filterexact" dynprm="0.02"/>', ""),
        ('<position name="drive" joint="rail" kp="30" kv="4" timeconst="0.05" ctrlrange="-1 -0.2"/>', ""),
    ],
)
def test_a_drive_follows_its_line_up_to_limits(actuator: str, joint: str) -> None:
    """Wherever they are; and filters have had their command for long."""
    model, motor = drive(actuator, joint)
    compiled = model.nominal()
    data = mujoco.MjData(compiled)
    for q, v, u in np.random.default_rng(0).uniform(-2.0, 2.0, (30, 3)):
        data.qpos[:], data.qvel[:], data.ctrl[:] = q, v, u
        if compiled.na:
            data.act[:] = np.clip(u, *compiled.actuator_ctrlrange[0]) if compiled.actuator_ctrllimited[0] else u
        mujoco.mj_forward(compiled, data)
        found = motor.force(np.array([[q]]), np.array([[v]]), np.array([[u]]))
        np.testing.assert_allclose(found, data.qfrc_actuator, rtol=1e-6)


def test_a_servos_rotor_stops_within_a_step_whatever_its_ranges() -> None:
    """The smallest one follows from its gains, also where the force is clipped at the origin."""
    ranges = 'ctrlrange="-3 -0.5" forcerange="-20 20"'
    lows = []
    for limits in ("", ranges):
        model = block(f'<position name="drive" joint="rail" kp="100" kv="100" {limits}/>')
        rotor = placed(model, "motor_side_elasticity", "rail").parameters[1]
        lows.append(rotor.low)
    np.testing.assert_allclose(lows, STEP * 100 + STEP**2 * 100, rtol=1e-6)


def test_a_command_beyond_its_range_has_wound_the_spring_no_further() -> None:
    """Where force and acceleration were steady nothing swings."""
    model = block('<motor name="drive" joint="rail" ctrlrange="-2 2"/>')
    extended = model.with_effect(placed(model, "joint_elasticity", "rail", scales_of(model)))
    values = {f"joint_elasticity@rail.{key}": value for key, value in spring(40.0, retardation=0.02).items()}
    speed = (2.0 / MASS * STEP * (np.arange(-AMID, 0.0) + 0.5))[None, :, None]
    history = History(np.zeros(1), np.zeros((1, AMID, 1)), speed, np.full((1, AMID, 1), FORCE))
    controls, rest = np.full((1, 300, 1), FORCE), np.zeros((1, 1, 1))
    rollout = Simulator(extended, 1, threads=1).replay(
        extended.space.vector(values)[None], rest, rest, controls, controls[:, :1], history
    )
    expected = 0.5 * 2.0 / MASS * (np.arange(301) * STEP) ** 2
    np.testing.assert_allclose(rollout.qpos[0, :, 0], expected, rtol=0, atol=5e-5)


@pytest.mark.parametrize(
    ("actuator", "arriving"),
    [
        ('<motor name="drive" joint="rail" ctrlrange="-2 2" ctrllimited="true"/>', 2.0),
        ('<general name="drive" joint="rail" dyntype="filterexact" dynprm="0.02"/>', FORCE),
    ],
)
def test_a_clipped_or_late_command_is_made_up_for(actuator: str, arriving: float) -> None:
    """The drive is asked for more than arrives; the centre of mass moves under what does."""
    model = block(actuator)
    extended = model.with_effect(placed(model, "joint_elasticity", "rail", scales_of(model)))
    values = {f"joint_elasticity@rail.{key}": value for key, value in spring(40.0, retardation=0.02).items()}
    controls, rest = np.full((1, 300, 1), FORCE), np.zeros((1, 1, 1))
    still = np.zeros((1, 5, 1))
    history = History(np.zeros(1), still, still, still)
    rollout = Simulator(extended, 1, threads=1).replay(
        extended.space.vector(values)[None], rest, rest, controls, controls[:, :1], history
    )
    gained = np.diff(rollout.qvel[0, 240:, 0]) / STEP
    np.testing.assert_allclose(gained, arriving / MASS, rtol=1e-3)


def test_a_drive_is_that_of_each_simulation() -> None:
    model = block()
    scaled = model.with_effect(placed(model, "torque_scale", "drive"))
    models = [scaled.compile(np.array([factor])) for factor in (0.5, 1.5)]
    motor = JointDrive.of([models[1], models[0], models[1]], "rail")
    np.testing.assert_allclose(motor.by_control, [[1.5], [0.5], [1.5]], rtol=1e-9)


def test_a_late_command_counts_at_once() -> None:
    model = block()
    late = model.with_effect(placed(model, "actuator_delay", "drive"))
    motor = JointDrive.of([late.compile(np.array([0.02]))], "rail")
    np.testing.assert_allclose(motor.by_control, [[1.0]], rtol=1e-9)


@pytest.mark.parametrize(
    ("name", "values"), [("stribeck_friction", {"excess": 1.0}), ("constant_offset", {"torque": 0.7})]
)
def test_a_drive_has_what_follows_a_line(name: str, values: Mapping[str, float]) -> None:
    """A clipped force would be taken far beyond its clip."""
    extended = block().with_effect(placed(block(), name, "rail"))
    z = extended.space.vector({f"{name}@rail.{key}": value for key, value in values.items()})
    motor = JointDrive.of([extended.compile(z)], "rail")
    np.testing.assert_allclose([motor.constant[0], motor.by_velocity[0]], [values.get("torque", 0.0), 0.0], atol=1e-9)


@pytest.mark.parametrize("elasticity", ["joint_elasticity", "motor_side_elasticity"])
@pytest.mark.parametrize(
    ("name", "values", "speed"),
    [
        ("stribeck_friction", {"kinetic": 0.5, "excess": 2.0, "speed": 0.1}, FORCE - 0.5),
        ("cogging", {"cosine": -FORCE, "periods": 5.0}, 0.0),
    ],
)
def test_cogging_winds_the_spring_and_friction_does_not(
    name: str, values: Mapping[str, float], speed: float, elasticity: str
) -> None:
    """What moved steadily against a damping of 1 N·s/m, or rested, goes on without swinging."""
    model = block(joint='damping="1"')
    extended = model.with_effect(placed(model, elasticity, "rail")).with_effect(placed(model, name, "rail"))
    both = ((elasticity, spring(40.0, retardation=0.02)), (name, values))
    z = extended.space.vector({f"{label}@rail.{key}": v for label, named in both for key, v in named.items()})[None]
    moved, shape = speed * STEP * (np.arange(-AMID, 0.0) + 0.5), (1, AMID, 1)
    history = History(np.zeros(1), moved.reshape(shape), np.full(shape, speed), np.full(shape, FORCE))
    start, controls = np.zeros((1, 1, 1)), np.full((1, 300, 1), FORCE)
    rollout = Simulator(extended, 1, threads=1).replay(z, start, start + speed, controls, controls[:, :1], history)
    np.testing.assert_allclose(rollout.qpos[0, :, 0], speed * STEP * np.arange(301), rtol=0, atol=1e-6)


def test_a_motor_cogs_by_its_gear_within_its_line() -> None:
    """What its line lacks comes on top, wherever the motor stands."""
    cogs = 'motorconst="0.5" resistance="2" cogging="0.7 6 0.4"'
    model, motor = drive(f'<dcmotor name="drive" joint="rail" gear="3" {cogs}/>')
    compiled = model.nominal()
    data = mujoco.MjData(compiled)
    for q, v, u in np.random.default_rng(0).uniform(-2.0, 2.0, (30, 3)):
        data.qpos[:], data.qvel[:], data.ctrl[:] = q, v, u
        mujoco.mj_forward(compiled, data)
        found = motor.force(np.array([[q]]), np.array([[v]]), np.array([[u]]))
        np.testing.assert_allclose(found, data.qfrc_actuator, rtol=1e-6)


def test_a_motor_that_diverges_is_infeasible_and_no_warning_tells_of_it() -> None:
    """A servo drives a rotor that is far too light for its gains at this step; warnings are errors in these tests."""
    model = block('<position name="drive" joint="rail" kp="2000" kv="60"/>')
    effect = "motor_side_elasticity"
    extended = model.with_effect(placed(model, effect, "rail"))
    values = {"compliance": 0.27, "rotor": 0.017, "retardation": 1e-4}
    z = extended.space.vector({f"{effect}@rail.{key}": value for key, value in values.items()})
    controls, rest = np.full((1, 1500, 1), 7.0), np.zeros((1, 1, 1))
    simulator = Simulator(extended, 1, threads=1)
    rollout = simulator.replay(z[None], rest, rest, controls, controls[:, :1])
    assert rollout.infeasible.all()
    assert not np.isfinite(rollout.qpos).all()
    sound = simulator.replay(extended.space.nominal[None], rest, rest, controls, controls[:, :1])
    assert not sound.infeasible.any()
    assert sound.qpos[0, -1, 0] == pytest.approx(7.0, abs=0.01)
