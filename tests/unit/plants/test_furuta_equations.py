"""The pendulum's equations against conservation of energy, a closed form and an independent engine."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from plant_machines import (
    LOSSLESS,
    POLE_ALONE,
    QUBE,
    TIGHT,
    UNPLUGGED,
    WEIGHTLESS,
    angular_frequency,
    no_command,
    samples,
)

from dr_lab.plants.command import Command
from dr_lab.plants.furuta import Furuta
from dr_lab.plants.hidden.base_tilt import BaseTilt
from dr_lab.plants.hidden.no_effect import NoEffect
from dr_lab.plants.motion import simulate


@pytest.mark.parametrize("angle", [0.0, 0.05])
def test_without_friction_and_input_energy_is_conserved(angle: float) -> None:
    tilted = LOSSLESS.with_gravity(BaseTilt(about_x=angle).alter(LOSSLESS).gravity)
    time = samples(2.0)
    states = simulate(tilted, NoEffect(), [no_command()], time, accuracy=TIGHT, start=(0.3, 2.5, 4.0, -3.0))
    energy = np.array([tilted.energy((s[0], s[1]), (s[2], s[3])) for s in states])
    assert np.ptp(states[:, 1]) > 3.0
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)


def test_damping_takes_the_power_that_it_dissipates() -> None:
    machine = replace(LOSSLESS, damping=(1e-4, 5e-5))
    time = np.arange(0.0, 2.0, 1e-4)
    states = simulate(machine, NoEffect(), [no_command()], time, accuracy=TIGHT, start=(0.0, 2.0, 3.0, 0.0))
    power = 1e-4 * states[:, 2] ** 2 + 5e-5 * states[:, 3] ** 2
    lost = np.trapezoid(power, time)
    first, last = (machine.energy((s[0], s[1]), (s[2], s[3])) for s in (states[0], states[-1]))
    assert first - last == pytest.approx(lost, rel=1e-6)


def test_hanging_pole_swings_at_its_closed_form_frequency() -> None:
    time, amplitude = samples(3.0), 1e-5
    states = simulate(LOSSLESS, NoEffect(), [no_command()], time, accuracy=TIGHT, start=(0.0, amplitude, 0.0, 0.0))
    expected = amplitude * np.cos(angular_frequency(LOSSLESS) * time)
    np.testing.assert_allclose(states[:, 1], expected, rtol=0, atol=1e-8 * amplitude)


def test_pole_on_a_held_arm_is_a_rod_pendulum() -> None:
    time, amplitude, rod = samples(3.0), 1e-5, math.sqrt(3 * 9.81 / (2 * 0.129))
    states = simulate(POLE_ALONE, NoEffect(), [no_command()], time, accuracy=TIGHT, start=(0.0, amplitude, 0.0, 0.0))
    np.testing.assert_allclose(states[:, 1], amplitude * np.cos(rod * time), rtol=0, atol=1e-7 * amplitude)


@pytest.mark.slow
def test_motor_reaches_the_no_load_speed() -> None:
    machine = replace(QUBE, damping=(0.0, 0.0), links=(QUBE.links[0], WEIGHTLESS), armature=(0.0, 1.0))
    step = Command(np.array([0.0]), np.array([3.0]))
    states = simulate(machine, NoEffect(), [step], np.array([0.0, 60.0]), accuracy=TIGHT)
    assert states[-1, 2] == pytest.approx(3.0 / 0.042, rel=1e-9)


def in_mujoco(machine: Furuta, tilt: float) -> mujoco.MjModel:
    """The same machine by a general-purpose engine: uniform thin rods on two hinges, a base turned about x."""
    rod = 1e-12  # kg·m², about the rod's own axis: MuJoCo refuses zero
    arm, pole = ((m, length, m * length**2 / 12) for m, length in ((0.095, 0.085), (0.024, 0.129)))
    assert machine.links[0].mass == arm[0]
    text = f"""
    <mujoco>
      <compiler angle="radian"/>
      <option timestep="2.5e-4" integrator="RK4" gravity="0 0 -9.81"><flag contact="disable"/></option>
      <worldbody><body euler="{tilt} 0 0"><body>
        <joint axis="0 0 1" damping="{machine.damping[0]!r}"/>
        <inertial mass="{arm[0]!r}" pos="{arm[1] / 2!r} 0 0" diaginertia="{rod} {arm[2]!r} {arm[2]!r}"/>
        <body pos="{arm[1]!r} 0 0">
          <joint axis="1 0 0" damping="{machine.damping[1]!r}"/>
          <inertial mass="{pole[0]!r}" pos="0 0 {-pole[1] / 2!r}" diaginertia="{pole[2]!r} {pole[2]!r} {rod}"/>
        </body>
      </body></body></worldbody>
    </mujoco>"""
    return mujoco.MjModel.from_xml_string(text)


@pytest.mark.parametrize("tilt", [0.0, 0.05])
def test_free_swing_agrees_with_another_engine(tilt: float) -> None:
    machine = replace(QUBE, drives=(UNPLUGGED,))
    model = in_mujoco(machine, tilt)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = (0.4, 2.0), (5.0, -2.0)
    time, rows = np.arange(1, 4001) * model.opt.timestep, []
    for _ in time:
        mujoco.mj_step(model, data)
        rows.append(data.qpos.copy())
    start = (0.4, 2.0, 5.0, -2.0)
    states = simulate(machine, BaseTilt(tilt), [no_command()], time, accuracy=TIGHT, start=start)
    np.testing.assert_allclose(states[:, :2], rows, rtol=0, atol=1e-6)
