"""Laws that act from step to step: motions with closed forms, and formulas that are refused."""

from collections.abc import Mapping

import mujoco
import numpy as np
import pytest
from effect_machines import block, hanging, placed, scales_of

from dr_lab.effects.effect import PlacedEffect, place
from dr_lab.effects.formula import Formula
from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.physics.law import History
from dr_lab.physics.model import Model
from dr_lab.physics.rollout import Rollout
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

MASS = 2.0  # kg, of the block
INERTIA = 0.005 + 0.5 * 0.3**2  # kg·m², of the pendulum about its hinge
WEIGHTLESS = 'gravity="0 0 0"'


def played(
    model: Model,
    effect: PlacedEffect,
    values: Mapping[str, float],
    seconds: float,
    start: tuple[float, float] = (0.0, 0.0),
    command: float = 0.0,
    history: History | None = None,
) -> tuple[Array, Rollout]:
    """Times, and a motion under a constant command; the same context twice, so that rows cannot be mixed up."""
    extended = model.with_effect(effect)
    z = np.tile(extended.space.vector({f"{effect.label}.{k}": v for k, v in values.items()}), (2, 1))
    step = extended.nominal().opt.timestep
    controls = np.full((1, round(seconds / step), 1), command)
    qpos, qvel = (np.full((2, 1, 1), x) for x in start)
    rollout = Simulator(extended, 2, threads=1).replay(z, qpos, qvel, controls, controls[:, :1], history)
    np.testing.assert_array_equal(rollout.qpos[0], rollout.qpos[1])
    return np.arange(len(rollout.qpos[0])) * step, rollout


def test_friction_follows_the_load() -> None:
    model = block()
    time, rollout = played(model, placed(model, "load_dependent_friction", "rail"), {"share": 0.2}, 0.5, command=4.0)
    expected = 0.5 * 4.0 * (1 - 0.2) / MASS * time**2
    np.testing.assert_allclose(rollout.qpos[0, :, 0], expected, atol=1e-4)


def test_the_load_of_one_replay_is_forgotten_in_the_next() -> None:
    extended = block().with_effect(placed(block(), "load_dependent_friction", "rail"))
    simulator, rest, controls = Simulator(extended, 1, threads=1), np.zeros((1, 1, 1)), np.full((1, 20, 1), 4.0)
    first, again, free = (
        simulator.replay(np.array([[share]]), rest, rest, controls, controls[:, :1]).qvel[0, -1, 0]
        for share in (0.2, 0.2, 0.0)
    )
    assert first == again
    assert free == pytest.approx(4.0 / MASS * 20 * 0.002)


def test_a_motor_that_holds_a_weight_presses_twice() -> None:
    """At 90° gravity asks for 0.5·9.81·0.3 N·m; the motor gives it, and the gear bears both."""
    model, weight = hanging(), 0.5 * 9.81 * 0.3
    effect = placed(model, "load_dependent_friction", "hinge")
    _, rollout = played(model, effect, {"share": 0.1}, 0.1, start=(np.pi / 2, 1.0), command=weight)
    assert rollout.qvel[0, 10, 0] - 1.0 == pytest.approx(-0.02 * 0.1 * 2 * weight / INERTIA, rel=0.02)


@pytest.mark.parametrize(
    ("other", "values"),
    [("constant_offset", {"torque": -3.0}), ("stribeck_friction", {"kinetic": 0.0, "excess": 3.0, "speed": 1.0})],
)
def test_what_other_effects_write_as_actuators_is_no_load_of_the_gear(other: str, values: dict[str, float]) -> None:
    beside = placed(block(), other, "rail")
    model, moving = block().with_effect(beside), {}
    effect = placed(block(), "load_dependent_friction", "rail")
    extended = model.with_effect(effect)
    for share in (0.0, 0.2):
        given = {f"{beside.label}.{name}": value for name, value in values.items()}
        simulator = Simulator(extended, 1, threads=1)
        simulator.set_contexts(extended.space.vector({**given, f"{effect.label}.share": share})[None])
        simulator.reset()
        simulator.batch.bind("qvel")[:] = 2.0
        simulator.step(np.full((1, 1), 4.0), 2)
        moving[share] = float(simulator.batch.bind("qvel")[0, 0])
    assert moving[0.2] - moving[0.0] == pytest.approx(-2 * 0.002 * 0.2 * 4.0 / MASS, rel=0.01)


def test_friction_over_the_turn_takes_its_work() -> None:
    """½ I (ω² − ω₀²) = −tau_m ∫ (1 + a sin θ + b cos θ) dθ without gravity."""
    model = hanging()
    model.spec.option.gravity = [0.0, 0.0, 0.0]
    values = {"mean": 0.05, "sine": 0.6, "cosine": -0.3}
    _, rollout = played(model, placed(model, "position_dependent_friction", "hinge"), values, 0.5, start=(0.0, 6.0))
    angle, speed = rollout.qpos[0, :, 0], rollout.qvel[0, :, 0]
    work = 0.05 * (angle + 0.6 * (1 - np.cos(angle)) - 0.3 * np.sin(angle))
    np.testing.assert_allclose(0.5 * INERTIA * speed**2, 0.5 * INERTIA * 36.0 - work, rtol=2e-4)


def test_torque_falls_with_speed() -> None:
    """v' = (F_stall/m) (1 − v/v_free) where more is asked for."""
    model = block()
    values = {"inverse_stall": 0.25, "inverse_speed": 0.5}
    time, rollout = played(model, placed(model, "torque_speed_limit", "drive"), values, 1.0, command=5.0)
    rate = 4.0 * 0.5 / MASS
    np.testing.assert_allclose(rollout.qvel[0, :, 0], 2.0 * (1 - np.exp(-rate * time)), atol=1e-5)


def test_below_the_limit_nothing_is_cut() -> None:
    model = block()
    values = {"inverse_stall": 0.25, "inverse_speed": 0.1}
    time, rollout = played(model, placed(model, "torque_speed_limit", "drive"), values, 0.5, command=2.0)
    np.testing.assert_allclose(rollout.qvel[0, :, 0], 2.0 / MASS * time, atol=1e-12)
    assert (rollout.controls[0] == 2.0).all()


@pytest.mark.parametrize("command", [1.0, 5.0, -3.0])
def test_a_motor_that_coasts_between_its_pulses_reaches_one_speed_by_any_command(command: float) -> None:
    """m v' = u − n |u| v: v = sign(u)/n (1 − exp(−n |u| t / m)), sooner by a larger command."""
    model = block()
    effect = placed(model, "coasting_bridge", "drive")
    time, rollout = played(model, effect, {"inverse_speed": 0.5}, 1.0, command=command)
    rate = 0.5 * abs(command) / MASS
    expected = np.sign(command) * 2.0 * (1 - np.exp(-rate * time))
    np.testing.assert_allclose(rollout.qvel[0, :, 0], expected, atol=1e-5)


@pytest.mark.parametrize(("command", "begun"), [(-1.0, 1.6), (12.0, 0.0)])
def test_the_range_of_a_command_bounds_what_drives_and_not_what_brakes(command: float, begun: float) -> None:
    """Reversed at speed it brakes by more than its range; beyond its range it is what its range allows."""
    model = block()
    actuator = model.spec.actuator("drive")
    actuator.ctrlrange, actuator.ctrllimited = [-1.0, 1.0], mujoco.mjtLimited.mjLIMITED_TRUE
    effect, sent = placed(model, "coasting_bridge", "drive"), np.clip(command, -1.0, 1.0)
    time, rollout = played(model, effect, {"inverse_speed": 0.5}, 0.5, start=(0.0, begun), command=command)
    fades = np.exp(-0.5 * time / MASS)
    np.testing.assert_allclose(rollout.qvel[0, :, 0], 2.0 * sent * (1 - fades) + begun * fades, atol=1e-4)


@pytest.mark.parametrize("order", [1, -1])
def test_the_range_that_bounds_a_coasting_motor_is_that_of_its_own_context(order: int) -> None:
    model = block().with_effect(placed(block(), "saturation", "drive"))
    model = model.with_effect(placed(model, "coasting_bridge", "drive"))
    labels = ("saturation@drive.inverse_limit", "coasting_bridge@drive.inverse_speed")
    z = np.array([model.space.vector(dict(zip(labels, (inverse, 0.5), strict=True))) for inverse in (1.0, 0.0)])
    rest, controls = np.zeros((2, 1, 1)), np.full((1, 250, 1), 5.0)
    rollout = Simulator(model, 2, threads=1).replay(z[::order], rest, rest, controls, controls[:, :1])
    time = np.arange(251) * 0.002
    for speed, command in zip(rollout.qvel[::order, :, 0], (1.0, 5.0), strict=True):
        np.testing.assert_allclose(speed, 2.0 * (1 - np.exp(-0.5 * command * time / MASS)), atol=1e-4)


def test_a_coasting_motor_behind_an_actuator_without_a_command_has_its_own_range() -> None:
    without = '<dcmotor name="brake" joint="rail" input="none" motorconst="1e-6" resistance="1"/>'
    model = block(without + '<motor name="drive" joint="rail" ctrllimited="true" ctrlrange="-1 1"/>')
    time, rollout = played(model, placed(model, "coasting_bridge", "drive"), {"inverse_speed": 0.5}, 0.5, command=5.0)
    np.testing.assert_allclose(rollout.qvel[0, :, 0], 2.0 * (1 - np.exp(-0.5 * time / MASS)), atol=1e-4)


def test_yielding_spring_swings_then_slips() -> None:
    """Below the yield a spring of tau_y/x_y; beyond it a constant force."""
    model = block()
    effect = placed(model, "hysteresis", "rail")
    way, force = 0.1, 5.0
    rate = np.sqrt(force / way / MASS)
    time, small = played(model, effect, {"torque": force, "displacement": way}, 1.0, start=(0.0, 0.09 * rate))
    np.testing.assert_allclose(small.qpos[0, :, 0], 0.09 * np.sin(rate * time), atol=1e-5)
    time, large = played(model, effect, {"torque": force, "displacement": way}, 0.5, start=(0.0, 3.0))
    slipping = large.qpos[0, :, 0] > way + 0.01
    fall = np.diff(large.qvel[0, slipping, 0]) / np.diff(time[slipping])
    np.testing.assert_allclose(fall, -force / MASS, rtol=1e-9)


def test_what_was_measured_before_has_stretched_the_spring() -> None:
    model = block()
    effect = placed(model, "hysteresis", "rail")
    steps, speed = 50, 0.5
    shape = (1, steps, 1)
    history = History(np.zeros(1), np.zeros(shape), np.full(shape, speed), np.zeros(shape))
    values = {"torque": 5.0, "displacement": 0.1}
    _, rollout = played(model, effect, values, 0.002, history=history)
    stretch = speed * steps * 0.002
    assert rollout.qvel[0, 1, 0] == pytest.approx(-0.002 * 5.0 * stretch / 0.1 / MASS, rel=1e-3)


def formula(text: str, *names: str, site: str = "rail") -> PlacedEffect:
    """The block's formula with parameters between −100 and 100."""
    free = {name: {"unit": "1", "nominal": 0.0, "low": -100.0, "high": 100.0} for name in names}
    return place(Formula(text, free), block().nominal(), site, scales_of(block()))


def test_a_written_spring_swings() -> None:
    time, rollout = played(block(), formula("-k * q", "k"), {"k": 18.0}, 1.0, start=(0.1, 0.0))
    np.testing.assert_allclose(rollout.qpos[0, :, 0], 0.1 * np.cos(3.0 * time), atol=2e-6)


def test_a_formula_knows_command_speed_and_the_logs_time() -> None:
    nothing = np.zeros((1, 0, 1))
    history = History(np.array([10.0]), nothing, nothing, nothing)
    effect = formula("a * u + b * (t - 10) - c * v", "a", "b", "c")
    time, ramp = played(block(), effect, {"b": 3.0}, 0.5, history=history)
    np.testing.assert_allclose(ramp.qvel[0, :, 0], 0.5 * 3.0 / MASS * time**2, atol=1e-12)
    _, pushed = played(block(), effect, {"a": 0.5, "c": 0.0}, 0.5, command=4.0)
    np.testing.assert_allclose(pushed.qvel[0, :, 0], 4.0 * 1.5 / MASS * time, atol=1e-12)
    _, slowed = played(block(), effect, {"c": 4.0}, 0.5, start=(0.0, 1.0))
    np.testing.assert_allclose(slowed.qvel[0, :, 0], np.exp(-4.0 / MASS * time), atol=1e-5)


def test_a_formula_knows_named_joints_and_actuators() -> None:
    named = formula("a * drive.u - k * rail.q - c * rail.v", "a", "k", "c")
    own = formula("a * u - k * q - c * v", "a", "k", "c")
    values = {"a": 0.5, "k": 18.0, "c": 1.0}
    paths = [played(block(), each, values, 0.5, start=(0.1, 0.2), command=3.0)[1].qpos for each in (named, own)]
    np.testing.assert_array_equal(paths[0], paths[1])


def test_a_formula_of_a_joint_that_is_not_there_is_refused() -> None:
    with pytest.raises(UnknownNameError, match=r"pole\.q.*drive\.u"):
        formula("k * pole.q", "k")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("-k * ", "cannot be read"),
        ("-k * p", "'p', which is not known"),
        ("k * __import__('os').getpid()", "formulas cannot|no function|not known"),
        ("k * q.real", "'q.real', which is not known"),
        ("k * [q][0]", "Subscript"),
        ("k * (q if q else v)", "IfExp"),
        ("k * eval(q)", "'eval'"),
        ("k * True", "not a number"),
    ],
)
def test_other_formulas_are_refused(text: str, told: str) -> None:
    with pytest.raises(ConfigError, match=told):
        formula(text, "k")


def test_parameters_that_a_formula_lacks_are_refused() -> None:
    with pytest.raises(ConfigError, match="'b' is not in it"):
        formula("-k * q", "k", "b")
    with pytest.raises(ConfigError, match="no nominal, low"):
        Formula("-k * q", {"k": {"unit": "1", "high": 1.0}})
    with pytest.raises(ConfigError, match="'v' cannot be a parameter"):
        formula("-k * v", "k", "v")
    with pytest.raises(ConfigError, match="low of the parameter 'k' is 'none'; expected a number"):
        Formula("-k * q", {"k": {"unit": "1", "nominal": 0.0, "low": "none", "high": 1.0}})
    with pytest.raises(UnknownNameError, match="lowest"):
        Formula("-k * q", {"k": {"unit": "1", "nominal": 0.0, "low": 0.0, "high": 1.0, "lowest": 0.0}})


def test_a_formula_that_is_no_number_diverges() -> None:
    extended = block().with_effect(formula("k / q", "k"))
    simulator = Simulator(extended, 2, threads=1)
    rest, controls = np.zeros((2, 1, 1)), np.zeros((1, 20, 1))
    places = np.array([0.5, 0.0])[:, None, None]
    rollout = simulator.replay(np.array([[0.0], [1.0]]), places, rest, controls, controls[:, :1])
    np.testing.assert_array_equal(rollout.infeasible, [False, True])
