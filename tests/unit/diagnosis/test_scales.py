import numpy as np
import pytest
from diagnosis_machines import clock, log_of, model_of, pendulum, simulated, solver_settings, windows_of

from dr_lab.diagnosis.fit.scales import machine_scales, with_replay
from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.effects.effect import Scales
from dr_lab.trajectory import Array, Log, Signal

TIME = clock(5000)
SIZE, RATE = 0.7, 2 * np.pi  # rad, rad/s: ten whole periods
INERTIA, MOMENT = 0.005 + 0.5 * 0.3**2, 0.5 * 9.81 * 0.3  # kg·m², N·m of the machines' pendulum
CARTPOLE = """<mujoco model="cartpole"><compiler angle="radian"/><worldbody><body name="cart">
  <joint name="rail" type="slide" axis="1 0 0"/><geom size="0.1" mass="2"/>
  <body name="pole"><joint name="hinge" axis="0 1 0"/><geom size="0.1" mass="1" pos="0 0 -1"/></body>
</body></worldbody></mujoco>"""


def swing() -> Array:
    return SIZE * np.sin(RATE * TIME)


def log(command: Array | None = None, **outputs: Array) -> Log:
    channels = {name.replace("_", "."): (TIME, value) for name, value in outputs.items()}
    return log_of("a", channels, None if command is None else Signal("drive", "N·m", TIME, command))


@pytest.mark.parametrize("drive", [0.3, 3.0])
def test_a_swinging_pendulum_has_the_scales_of_its_closed_forms(drive: float) -> None:
    """Its force is that of its motion, or its motor's where that is larger."""
    found = machine_scales(pendulum().nominal(), [log(drive * np.cos(TIME), hinge_position=swing())], 0.03)
    assert found.position["hinge"] == pytest.approx(2 * SIZE, rel=0.01)
    assert found.speed["hinge"] == pytest.approx(SIZE * RATE * np.sin(0.95 * np.pi / 2), rel=0.01)
    inertial = INERTIA * RATE**2 * swing()
    weight = MOMENT * np.sin(swing())
    moving, driven = np.mean(inertial**2 + weight**2) ** 0.5, drive * np.mean(np.cos(TIME) ** 2) ** 0.5
    assert found.torque["hinge"] == pytest.approx(max(moving, driven), rel=0.02)
    assert found.command == {"drive": pytest.approx(drive)}


@pytest.mark.parametrize("hole", [0.2, 1.0, 3.0])
def test_a_hole_in_a_log_makes_no_scale_larger(hole: float) -> None:
    seen = np.abs(TIME - 2.1 - hole / 2) > hole / 2
    noisy = swing() + 1e-3 * np.random.default_rng(0).normal(size=len(TIME))
    one = log_of("a", {"hinge.position": (TIME[seen], noisy[seen])})
    whole = machine_scales(pendulum().nominal(), [log(hinge_position=noisy)], 0.03)
    found = machine_scales(pendulum().nominal(), [one], 0.03)
    assert found.position["hinge"] <= 1.01 * whole.position["hinge"]
    assert 0.5 * whole.speed["hinge"] < found.speed["hinge"] <= 1.01 * whole.speed["hinge"]
    assert 0.5 * whole.torque["hinge"] < found.torque["hinge"] <= 1.05 * whole.torque["hinge"]


def test_all_logs_count_and_a_missing_command_is_none() -> None:
    found = machine_scales(
        pendulum().nominal(), [log(hinge_position=swing()), log(hinge_position=3 + 2 * swing())], 0.03
    )
    assert found.position["hinge"] == pytest.approx(3 + 3 * SIZE, rel=0.01)
    assert found.command == {"drive": 0.0}


def test_a_joint_whose_velocity_alone_is_measured_has_a_speed_and_a_force() -> None:
    model = model_of(CARTPOLE).nominal()
    found = machine_scales(model, [log(rail_velocity=swing(), hinge_position=0 * TIME)], 0.03)
    assert found.speed["rail"] == pytest.approx(SIZE * np.sin(0.95 * np.pi / 2), rel=0.01)
    assert found.torque["rail"] == pytest.approx(3.0 * SIZE * RATE / np.sqrt(2), rel=0.02)
    assert found.position["rail"] == 0.0


def test_a_joint_without_a_channel_still_carries_its_weight() -> None:
    model = model_of(CARTPOLE).nominal()
    found = machine_scales(model, [log(rail_position=swing())], 0.03)
    assert found.speed["hinge"] == 0.0
    assert found.torque["hinge"] > 0.0


TWO = """<mujoco model="two"><compiler angle="radian"/><option timestep="0.002" integrator="RK4"/><worldbody>
  <body><joint name="seen" axis="0 1 0"/><geom size="0.1" mass="1" pos="0 0 -1"/></body>
  <body pos="0 5 0"><joint name="hidden" axis="0 1 0"/><geom size="0.1" mass="1" pos="0 0 -1"/></body>
</worldbody></mujoco>"""


def coupled() -> dict[str, Array]:
    """The cart moved by its pole, which swings out from 0.5 rad."""
    return simulated(model_of(CARTPOLE).nominal(), None, 3.0, qpos=[0.0, 0.5])


def with_model(xml: str, seen: Log) -> Scales:
    """Scales of a log, and of the model in it."""
    model = model_of(xml)
    replay, fit = fit_states(model, model.space.nominal, windows_of(model, [seen]), solver_settings(), 1)
    return with_replay(machine_scales(model.nominal(), [seen], 0.03), replay, fit)


def test_a_joint_that_no_channel_measures_has_the_scales_of_the_models_motion() -> None:
    motion = coupled()
    channels = {f"{name}.position": (motion["time"], motion["qpos"][:, k]) for k, name in enumerate(("rail", "hinge"))}
    both = machine_scales(model_of(CARTPOLE).nominal(), [log_of("a", channels)], 0.03)
    found = with_model(CARTPOLE, log_of("a", {"rail.position": channels["rail.position"]}))
    assert (found.unmeasured, found.unknown) == ({"hinge"}, set())
    assert found.position["hinge"] == pytest.approx(both.position["hinge"], rel=0.1)
    assert found.speed["hinge"] == pytest.approx(both.speed["hinge"], rel=0.1)
    assert found.torque["hinge"] == pytest.approx(both.torque["hinge"], rel=0.1)
    assert found.speed["rail"] == pytest.approx(both.speed["rail"], rel=1e-9)


def test_where_the_velocity_alone_is_measured_the_range_is_the_models() -> None:
    motion = coupled()
    velocity = motion["qvel"][:, 1]
    found = with_model(CARTPOLE, log_of("a", {"hinge.velocity": (motion["time"], velocity)}))
    assert "hinge" in found.unmeasured
    assert found.position["hinge"] > 0.1
    assert found.speed["hinge"] == pytest.approx(np.percentile(np.abs(velocity), 95), rel=0.05)


def test_of_a_joint_that_rests_unseen_nothing_is_known() -> None:
    motion = simulated(model_of(TWO).nominal(), None, 3.0, qpos=[0.5, 0.0])
    found = with_model(TWO, log_of("a", {"seen.position": (motion["time"], motion["qpos"][:, 0])}))
    assert found.unknown == {"hidden"}


def test_of_a_model_that_diverges_nothing_is_known() -> None:
    motion = coupled()
    stiff = CARTPOLE.replace('type="slide"', 'type="slide" damping="1e6"').replace(
        "<world", '<option integrator="RK4"/><world'
    )
    found = with_model(stiff, log_of("a", {"rail.position": (motion["time"], motion["qpos"][:, 0])}))
    assert found.unknown == {"hinge"}
