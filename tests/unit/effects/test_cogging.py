from dataclasses import replace

import numpy as np
import pytest
from effect_machines import acceleration, block, catalogue_effect, hanging, motion, placed, scales_of, with_effect

from dr_lab.effects.cogging import Cogging
from dr_lab.effects.effect import place
from dr_lab.effects.periodic import tried
from dr_lab.errors import ModelError
from dr_lab.physics.model import Model

INERTIA = 0.005 + 0.5 * 0.3**2  # kg·m², of the hanging pendulum about its hinge
PERIODS = 12  # the usual number


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


def test_a_linear_motors_force_repeats_with_its_pitch() -> None:
    pitch, amplitude = 0.02, 3.0
    model = with_effect(block(), "cogging", "rail", sine=amplitude, cosine=0.0, periods=2 * np.pi / pitch)
    for place_of, share in ((0.0, 0.0), (pitch / 4, 1.0), (pitch / 2, 0.0), (7.75 * pitch, -1.0)):
        assert acceleration(model, qpos=place_of) == pytest.approx(share * amplitude / 2.0, abs=1e-9)


def test_a_number_that_the_user_gives_is_not_searched() -> None:
    found = catalogue_effect("cogging")
    assert isinstance(found, Cogging)
    effect = replace(found, periods=9)
    one = place(effect, turning().nominal(), "hinge", scales_of(turning()))
    assert [p.name for p in one.parameters] == ["cogging@hinge.sine", "cogging@hinge.cosine"]
    assert not one.starts
    extended = turning().with_effect(one)
    model = extended.compile(np.array([0.3, 0.0]))
    assert acceleration(model, qpos=0.1) == pytest.approx(0.3 * np.sin(0.9) / INERTIA)


def test_searched_are_numbers_that_the_way_and_the_step_can_tell() -> None:
    scales = scales_of(turning(), position=0.5, speed=10.0)  # rad, rad/s; the step is 2 ms
    number = placed(turning(), "cogging", "hinge", scales).parameters[-1]
    assert (number.unit, number.low, number.high) == ("1/turn", pytest.approx(np.pi / 0.5), pytest.approx(50.0))
    np.testing.assert_array_equal(tried(number, 0.5), np.arange(7, 51))
    slide = replace(number, unit="rad/m", low=10.0, high=100.0)
    assert np.diff(tried(slide, 0.5)) == pytest.approx(np.pi / 2 / 0.5)


def test_a_joint_that_hardly_moves_has_no_number_that_can_be_told() -> None:
    with pytest.raises(ModelError, match=r"Of 3 to 120 1/turn no number .* 314 .* Give effects\.cogging\.periods"):
        placed(turning(), "cogging", "hinge", scales_of(turning(), position=0.01))
