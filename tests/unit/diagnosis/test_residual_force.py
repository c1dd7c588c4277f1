from dataclasses import replace

import mujoco
import numpy as np
import pytest
from diagnosis_machines import (
    NOISE,
    log_of,
    model_of,
    pendulum,
    predicted_settings,
    simulated,
    solver_settings,
    steps_command,
    swinging,
    windows_of,
    windows_settings,
)
from slider_crank import MJCF, logs

from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.diagnosis.missing_force.residual_force import ResidualForce, residual_forces
from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.physics.model import Model
from dr_lab.trajectory import Log

TWO_LINKS = """<mujoco model="two">
  <compiler angle="radian"/><option timestep="0.002" integrator="RK4"/>
  <worldbody><body name="upper">
    <inertial mass="0.5" pos="0 0 -0.2" diaginertia="0.005 0.005 0.001"/>
    <joint name="hinge" axis="0 1 0" damping="0.02"/>
    <body name="lower" pos="0 0 -0.4">
      <inertial mass="0.3" pos="0 0 -0.15" diaginertia="0.003 0.003 0.001"/>
    <joint name="elbow" axis="0 1 0" damping="0.02"/>
    </body></body></worldbody>
  <actuator><motor name="drive" joint="hinge"/></actuator>
</mujoco>"""
SHORT = (predicted_settings(length=0.06, seconds=1000.0), windows_settings(length=0.15))


def forces(model: Model, log: Log, settings: WindowSettings) -> dict[str, ResidualForce]:
    return residual_forces(
        *fit_states(model, model.space.nominal, windows_of(model, [log], settings), solver_settings(), 1),
        solver_settings(),
    )


@pytest.mark.parametrize("settings", SHORT, ids=["predicted", "refitted"])
@pytest.mark.parametrize("torque", [0.0, 0.2])
def test_a_constant_torque_is_recovered(settings: WindowSettings, torque: float) -> None:
    def push(data: mujoco.MjData) -> None:
        data.qfrc_applied[0] = torque

    model = pendulum()
    found = forces(model, swinging("a", model.nominal(), 0, force=push), settings)["hinge"].force
    error = np.std(found) / np.sqrt(len(found))
    assert abs(np.mean(found) - torque) < 4 * error + 0.01 * torque
    assert np.std(found) < 0.012


@pytest.mark.parametrize(
    "settings", [pytest.param(SHORT[0], marks=pytest.mark.slow), SHORT[1]], ids=["predicted", "refitted"]
)
def test_forces_of_a_right_model_scatter_as_their_noise_says(settings: WindowSettings) -> None:
    model = pendulum()
    logs = [swinging(f"log_{k}", model.nominal(), k) for k in range(8)]
    replay, fit = fit_states(model, model.space.nominal, windows_of(model, logs, settings), solver_settings(), 1)
    found = residual_forces(replay, fit, solver_settings())["hinge"]
    scatter = np.mean((found.force / found.noise) ** 2)
    assert scatter == pytest.approx(1.0, abs=4 * np.sqrt(2 / len(found.force)))


def test_friction_shows_as_a_force_against_the_velocity() -> None:
    def rub(data: mujoco.MjData) -> None:
        data.qfrc_applied[0] = -0.1 * np.sign(data.qvel[0])

    model = pendulum()
    found = forces(model, swinging("a", model.nominal(), 0, force=rub, seconds=6.0), SHORT[0])["hinge"]
    fast = np.abs(found.velocity) > 2.0  # no reversal within the window
    np.testing.assert_allclose(found.force[fast], -0.1 * np.sign(found.velocity[fast]), atol=0.025)


def test_a_torque_is_told_apart_from_its_reaction_on_other_joints() -> None:
    def push(data: mujoco.MjData) -> None:
        data.qfrc_applied[:] = 0.0, 0.05

    model, command = model_of(TWO_LINKS), steps_command("drive", 1.0, 3.0, seed=0)
    motion = simulated(model.nominal(), command, 3.0, qpos=[0.5, -0.3], force=push)
    noise = NOISE * np.random.default_rng(0).normal(size=motion["qpos"].shape)
    names = ("hinge.position", "elbow.position")
    outputs = {name: (motion["time"], (motion["qpos"] + noise)[:, k]) for k, name in enumerate(names)}
    found = forces(model, log_of("a", outputs, command), SHORT[0])
    for joint, torque in (("hinge", 0.0), ("elbow", 0.05)):
        force = found[joint].force
        assert np.mean(force) == pytest.approx(torque, abs=4 * np.std(force) / np.sqrt(len(force)) + 0.001)


def test_windows_that_diverge_have_no_force() -> None:
    model = pendulum()
    windows = windows_of(model, [swinging("a", model.nominal(), 0)])
    replay, fit = fit_states(model, model.space.nominal, windows, solver_settings(), 1)
    lost = np.arange(len(windows)) == 2
    fit = type(fit)(fit.z, fit.delta, fit.residuals, fit.cost, lost, fit.slopes)
    np.testing.assert_array_equal(np.isnan(residual_forces(replay, fit, solver_settings())["hinge"].force), lost)


@pytest.mark.slow
def test_of_a_closed_chain_the_first_joint_bears_the_force_and_all_masses_count() -> None:
    """A slider-crank by its own equation, of whose torque 0.1 N·m are not logged."""
    torque, xml = 0.1, MJCF.format('solref="0.002 1"').replace('mass="1"', 'mass="1.05"')
    model = model_of(xml.replace('integrator="implicitfast"', 'integrator="RK4"').replace("0.01", "0.02"))
    (log,) = logs("a", seconds=2.0, noise=(1e-4, 1e-5))
    motor = log.commands["motor"]
    found = forces(
        model,
        replace(log, commands={"motor": replace(motor, value=motor.value - torque)}),
        windows_settings(length=0.15),
    )
    assert list(found) == ["crank"]
    assert np.median(found["crank"].force) == pytest.approx(torque, rel=0.05)
