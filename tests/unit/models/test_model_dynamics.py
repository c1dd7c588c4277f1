"""The models' motion against closed forms and hand-derived equations with the documented constants."""

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from dr_lab.cli.folders import shipped

FOLDER = shipped() / "model"
G = 9.81


def spec_of(name: str) -> mujoco.MjSpec:
    return mujoco.MjSpec.from_file(str(FOLDER / f"{name}.xml"))


def rod(mass: float, length: float) -> float:
    """Inertia of a uniform rod about its end, kg m^2."""
    return mass * length**2 / 3


def first_quarter(model: mujoco.MjModel, joint: str, amplitude: float) -> float:
    """Time in s from rest at `amplitude` to the joint's first zero crossing."""
    data = mujoco.MjData(model)
    address = int(model.joint(joint).qposadr[0])
    data.qpos[address] = amplitude
    before = amplitude
    while True:
        mujoco.mj_step(model, data)
        now = float(data.qpos[address])
        if now <= 0:
            return float(data.time) - model.opt.timestep * now / (now - before)
        before = now


@pytest.mark.parametrize(
    ("name", "joint", "squared"),
    [
        ("pendulum", "pendulum", 0.676 * G * 0.45 / (0.546 * 0.5**2 + rod(0.13, 0.48) + 36 * 6.07e-5)),
        ("multiarm", "arm1", 0.1476 * G * 0.1478 / (1.09e-4 + 0.1476 * 0.1478**2)),
        ("multiarm_double", "arm2", 0.1376 * G * 0.1168 / (1.27e-3 + 0.1376 * 0.1168**2)),
        ("furuta", "pole", 1.5 * G / 0.129),
        ("cartpole", "pole", 1.5 * G / (2 * 0.16825)),
    ],
)
def test_small_oscillations_have_the_closed_form_frequency(name: str, joint: str, squared: float) -> None:
    spec = spec_of(name)
    for each in spec.joints:
        each.damping = np.zeros(3)
        if each.name != joint:
            each.armature = 1e9  # held
    quarter = first_quarter(spec.compile(), joint, amplitude=0.01)
    period = 2 * np.pi / np.sqrt(squared) * (1 + 0.01**2 / 16)
    assert 4 * quarter == pytest.approx(period, rel=1e-5)


def acceleration(name: str, q: NDArray, v: NDArray, u: NDArray) -> NDArray:
    model = spec_of(name).compile()
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = q, v
    data.ctrl[:] = u
    mujoco.mj_forward(model, data)
    return data.qacc.copy()


C1 = (0.5234602302, 0.6255677234, 0.2, 0.2, 0.2556930544, 0.0318871996, 0.0508698481, 6.287203963e-5)
A0 = (0.5593806151, 0.6043459469, 0.3, 0.3, 0.1837768608, 0.0534708103, 0.0239237453, 7.659297953e-5)


@pytest.mark.parametrize(("name", "constants"), [("double_pendulum_c1", C1), ("double_pendulum_a0", A0)])
@pytest.mark.parametrize("seed", range(5))
def test_double_pendulum_obeys_the_documented_equations(name: str, constants: tuple[float, ...], seed: int) -> None:
    m1, m2, l1, r1, r2, i1, i2, rotor = constants  # inertias about the joints
    rng = np.random.default_rng(seed)
    q, v, torque = rng.uniform(-3, 3, 2), rng.uniform(-5, 5, 2), rng.uniform(-2, 2, 2)
    gear, h = 6, m2 * l1 * r2
    c, s = np.cos(q[1]), np.sin(q[1])
    coupling = i2 + h * c - gear * rotor
    mass = np.array(
        [
            [i1 + i2 + m2 * l1**2 + 2 * h * c + (gear**2 + 1) * rotor, coupling],
            [coupling, i2 + gear**2 * rotor],
        ]
    )
    bias = np.array([-h * s * v[1] * (2 * v[0] + v[1]), h * s * v[0] ** 2])
    outer = m2 * G * r2 * np.sin(q.sum())
    gravity = np.array([(m1 * r1 + m2 * l1) * G * np.sin(q[0]) + outer, outer])
    expected = np.linalg.solve(mass, torque - bias - gravity)
    np.testing.assert_allclose(acceleration(name, q, v, torque), expected, rtol=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_furuta_obeys_the_lagrangian_equations(seed: int) -> None:
    arm, pole, length, rod_length = 0.095, 0.024, 0.085, 0.129
    rng = np.random.default_rng(seed)
    q, v, voltage = rng.uniform(-3, 3, 2), rng.uniform(-10, 10, 2), rng.uniform(-6, 6)
    c, s = np.cos(q[1]), np.sin(q[1])
    hub, j, p = rod(arm, length) + pole * length**2, rod(pole, rod_length), pole * length * rod_length / 2
    own = 1e-9  # the file's stand-in for a thin rod's inertia about its own axis
    mass = np.array([[hub + j * s**2 + own * c**2, p * c], [p * c, j]])
    bias = np.array([2 * (j - own) * s * c * v[0] * v[1] - p * s * v[1] ** 2, -(j - own) * s * c * v[0] ** 2])
    gravity = np.array([0, pole * G * rod_length / 2 * s])
    force = np.array([0.042 * (voltage - 0.042 * v[0]) / 8.4 - 1e-4 * v[0], -5e-5 * v[1]])
    expected = np.linalg.solve(mass, force - bias - gravity)
    np.testing.assert_allclose(acceleration("furuta", q, v, np.array([voltage])), expected, rtol=1e-7)


@pytest.mark.parametrize("seed", range(5))
def test_cartpole_obeys_the_documented_equations(seed: int) -> None:
    cart, pole, half = 0.38, 0.127, 0.16825
    gear, pinion, ohm, k, efficiency = 3.71, 6.35e-3, 2.6, 7.67e-3, 0.9 * 0.9
    rng = np.random.default_rng(seed)
    q, v, voltage = rng.uniform(-3, 3, 2), rng.uniform(-2, 2, 2), rng.uniform(-6, 6)
    c, s = np.cos(q[1]), np.sin(q[1])
    rotor = 0.9 * gear**2 * 3.9e-7 / pinion**2
    mass = np.array([[cart + pole + rotor, pole * half * c], [pole * half * c, rod(pole, 2 * half)]])
    drive = efficiency * gear * k / (ohm * pinion) * (voltage - gear * k * v[0] / pinion)
    force = np.array(
        [
            drive - 5.4 * v[0] + pole * half * s * v[1] ** 2,
            -0.0024 * v[1] - pole * half * G * s,
        ]
    )
    expected = np.linalg.solve(mass, force)
    np.testing.assert_allclose(acceleration("cartpole", q, v, np.array([voltage])), expected, rtol=1e-5)


def test_motor_runs_up_exponentially() -> None:
    spec = spec_of("furuta")
    spec.delete(spec.body("pole"))
    model = spec.compile()
    data = mujoco.MjData(model)
    data.ctrl[0] = 3.0  # V
    drag, inertia = 0.042**2 / 8.4 + 1e-4, rod(0.095, 0.085)
    for _ in range(200):
        mujoco.mj_step(model, data)
    final = 0.042 / 8.4 * 3.0 / drag
    assert data.qvel[0] == pytest.approx(final * (1 - np.exp(-drag * data.time / inertia)), rel=1e-8)


def test_emps_is_a_mass_under_a_force() -> None:
    assert acceleration("emps", np.array([0.1]), np.array([0.3]), np.array([20.0]))[0] == pytest.approx(20 / 95.1089)


def test_multiarm_sensors_give_the_outer_arms_absolute_angle() -> None:
    model = spec_of("multiarm_double").compile()
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = (0.4, -1.1), (2.0, 3.0)
    mujoco.mj_forward(model, data)
    assert data.sensor("arm2_absolute").data[0] == pytest.approx(-0.7)
    assert data.sensor("arm2_absolute_rate").data[0] == pytest.approx(5.0)


def test_hopper_has_the_task_s_masses_and_period() -> None:
    model = spec_of("hopper").compile()
    lengths, radii = np.array([0.4, 0.45, 0.5, 0.39]), np.array([0.05, 0.05, 0.04, 0.06])
    volumes = np.pi * radii**2 * (lengths + 4 / 3 * radii)
    np.testing.assert_allclose(model.body_mass[1:], 1000 * volumes, rtol=1e-12)
    assert model.opt.timestep == 0.002
    np.testing.assert_array_equal(model.actuator_gear[:, 0], 200)
    np.testing.assert_array_equal(model.actuator_ctrlrange, [[-1, 1]] * 3)
    np.testing.assert_array_equal(model.dof_armature, [0, 0, 0, 1, 1, 1])
    np.testing.assert_array_equal(
        model.dof_damping[:, 0] if model.dof_damping.ndim > 1 else model.dof_damping, [0, 0, 0, 1, 1, 1]
    )
    np.testing.assert_allclose(model.qpos0, [0, 1.25, 0, 0, 0, 0])


def test_ball_weighs_and_drags_as_a_shell_of_its_size() -> None:
    spec = spec_of("ball")
    model = spec.compile()
    radius = 0.29 / (2 * np.pi)
    np.testing.assert_allclose(model.body("ball").inertia, 2 / 3 * model.body("ball").mass[0] * radius**2, rtol=1e-5)
    assert acceleration("ball", np.array([40.0]), np.array([-5.0]), np.zeros(0))[0] == pytest.approx(-G)
    spec.option.density = 1.2
    falling, data = spec.compile(), mujoco.MjData(model)
    data.qvel[:] = -10.0
    mujoco.mj_forward(falling, data)
    assert data.qfrc_fluid[0] == pytest.approx(2 * 1.2 * radius**2 * 10.0**2, rel=1e-5)


def test_cube_slides_under_dry_friction() -> None:
    spec = spec_of("cube")
    for geom in spec.geoms:
        geom.friction[0] = 0.18
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[2], data.qvel[0] = 0.0524, 1.0
    mujoco.mj_step(model, data, nstep=round(0.3 / model.opt.timestep))
    assert data.qvel[0] == pytest.approx(1.0 - 0.18 * G * data.time, rel=0.02)


def test_cube_s_sensors_tell_its_free_joint() -> None:
    model = spec_of("cube").compile()
    data = mujoco.MjData(model)
    data.qpos[:] = [0.1, -0.2, 0.3, 0.5, -0.5, 0.5, 0.5]
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.sensordata, data.qpos, atol=1e-12)
    np.testing.assert_allclose(model.body("cube").inertia, 0.2950002913583124 * 0.0524**2, rtol=1e-4)


@pytest.mark.parametrize(
    ("name", "volts_per_input", "supply", "stall", "no_load"),
    [("servo_xl330", 1.0, 5.0, 0.52, 10.79), ("servo_sts3250", 32 * 0.1638 * 12.0, 12.0, 4.9, 7.85)],
)
def test_servos_obey_their_data_sheets(
    name: str, volts_per_input: float, supply: float, stall: float, no_load: float
) -> None:
    """The torque at the joint is K (V - K q') / R, the voltage of a position servo being its gain times the error."""
    model = spec_of(name).compile()
    data = mujoco.MjData(model)
    for speed, share in ((0.0, 1.0), (no_load, 1.0), (3.0, 0.4), (-2.0, -0.7)):
        data.qpos[:], data.qvel[:] = 0.0, speed
        data.ctrl[:] = share * supply / volts_per_input
        mujoco.mj_forward(model, data)
        assert data.qfrc_actuator[0] == pytest.approx(stall * (share - speed / no_load), abs=1e-4 * stall)


def test_position_servo_clips_its_voltage() -> None:
    model = spec_of("servo_sts3250").compile()
    data = mujoco.MjData(model)
    data.ctrl[:] = 2.0  # rad, ten times what saturates it
    mujoco.mj_forward(model, data)
    assert data.qfrc_actuator[0] == pytest.approx(4.9, rel=1e-4)
