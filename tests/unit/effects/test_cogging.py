import mujoco
import numpy as np
import pytest
from effect_machines import acceleration, block, hanging, motion, placed, with_effect

from dr_lab.physics.model import Model

INERTIA = 0.005 + 0.5 * 0.3**2  # kg·m², of the hanging pendulum about its hinge
PERIODS = 12


def turning() -> Model:
    """The pendulum without gravity."""
    machine = hanging()
    machine.spec.option.gravity = [0.0, 0.0, 0.0]
    return machine


def test_torque_is_the_sum_of_two_phases() -> None:
    model = with_effect(turning(), "cogging", "hinge", sine=0.3, cosine=-0.2)
    for angle in np.linspace(-3.0, 3.0, 13):
        torque = 0.3 * np.sin(PERIODS * angle) - 0.2 * np.cos(PERIODS * angle)
        assert acceleration(model, qpos=angle, qvel=2.0) == pytest.approx(torque / INERTIA, rel=1e-9, abs=1e-9)


def test_small_swings_about_a_detent_have_the_period_of_its_spring() -> None:
    model = with_effect(turning(), "cogging", "hinge", sine=-0.3, cosine=0.0)
    time, position, _ = motion(model, 1.0, qpos=1e-4).T
    omega = np.sqrt(0.3 * PERIODS / INERTIA)
    np.testing.assert_allclose(position, 1e-4 * np.cos(omega * time), atol=2e-7)


def test_energy_is_kept_over_many_teeth() -> None:
    model = with_effect(turning(), "cogging", "hinge", sine=0.1, cosine=0.1)
    _, position, speed = motion(model, 2.0, qvel=5.0).T
    potential = (0.1 * np.cos(PERIODS * position) - 0.1 * np.sin(PERIODS * position)) / PERIODS
    energy = INERTIA * speed**2 / 2 + potential
    np.testing.assert_allclose(energy, energy[0], rtol=1e-6)
    assert np.ptp(speed) > 0.05


def test_neither_commands_nor_states_are_added() -> None:
    one = with_effect(turning(), "cogging", "hinge", sine=0.0, cosine=0.0)
    assert (one.nu, one.na, one.nactuator) == (1, 0, 2)
    assert one.actuator("cogging@hinge").id == 1


def test_slides_have_no_rotor() -> None:
    effect = placed(hanging(), "cogging", "hinge").effect
    assert effect.sites(block().nominal()) == ()
    ball = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body><joint name="b" type="ball"/><geom size="1"/></body></worldbody></mujoco>'
    )
    assert effect.sites(ball) == ()
