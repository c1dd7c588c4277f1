"""A part of a link that swings on its own, against closed forms of two masses and of a driven oscillator."""

import numpy as np
import pytest
from effect_machines import block, placed

from dr_lab.physics.law import History, MotionLaw
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

MASS, FORCE = 2.0, 4.0  # kg of the link, N
STEP, SECONDS = 0.002, 0.6
FAR, INTERVAL, NEAR = 480, 0.01, 100  # intervals and s of each; steps


def pushed(part: float, frequency: float, damping: float = 0.01) -> tuple[Array, Array]:
    """Times, and places of the link that a force pushes from rest."""
    model = block()
    extended = model.with_effect(placed(model, "flexible_mode", "rail"))
    values = {"inertia": part, "period": 2 * np.pi / frequency, "damping": damping}
    z = extended.space.vector({f"flexible_mode@rail.{key}": value for key, value in values.items()})
    controls, rest = np.full((1, round(SECONDS / STEP), 1), FORCE), np.zeros((1, 1, 1))
    rollout = Simulator(extended, 1, threads=1).replay(z[None], rest, rest, controls, controls[:, :1])
    return np.arange(rollout.qpos.shape[1]) * STEP, rollout.qpos[0, :, 0]


@pytest.mark.parametrize("part", [0.05, 0.5, 2.0])
def test_link_and_part_swing_against_each_other(part: float) -> None:
    """δ = −F/(M Ω²) (1 − cos Ωt) with Ω² = ω² (1 + J/M); the centre of mass does not know of it."""
    frequency = 20.0
    time, place = pushed(part, frequency, damping=0.003)
    turn = frequency * np.sqrt(1 + part / MASS)
    behind = -FORCE / MASS / turn**2 * (1 - np.cos(turn * time))
    moved = part / (MASS + part) * behind
    expected = 0.5 * FORCE / (MASS + part) * time**2 - moved
    np.testing.assert_allclose(place, expected, rtol=0, atol=0.05 * np.abs(moved).max())


def test_momentum_is_what_the_force_gave() -> None:
    """Damping takes energy and no momentum: a damped part ends up moving with its link."""
    time, place = pushed(0.5, 50.0, damping=0.7)
    speed = (place[-1] - place[-51]) / (50 * STEP)
    assert speed == pytest.approx(FORCE / (MASS + 0.5) * time[-26], rel=2e-3)


def test_a_part_of_no_inertia_is_none() -> None:
    time, place = pushed(0.0, 20.0)
    np.testing.assert_allclose(place, 0.5 * FORCE / MASS * time**2, rtol=0, atol=0.01 * STEP)


@pytest.mark.parametrize("damping", [0.003, 0.7])
def test_the_heaviest_and_fastest_part_gains_no_energy(damping: float) -> None:
    """Pushed for 0.6 s, its swing about the centre of mass stays as large as it was, or falls."""
    model = block()
    effect = placed(model, "flexible_mode", "rail")
    extended = model.with_effect(effect)
    inertia, period, _ = effect.parameters
    values = {inertia.name: inertia.high, period.name: period.low, f"{effect.label}.damping": damping}
    controls, rest = np.zeros((1, 2500, 1)), np.zeros((1, 1, 1))
    controls[0, :20] = FORCE
    rollout = Simulator(extended, 1, threads=1).replay(
        extended.space.vector(values)[None], rest, rest, controls, controls[:, :1]
    )
    speed = np.diff(rollout.qpos[0, :, 0]) / STEP
    early, late = speed[100:600], speed[-500:]
    assert np.isfinite(speed).all()
    assert np.ptp(late) <= 1.02 * np.ptp(early)
    assert late.mean() == pytest.approx(FORCE * 20 * STEP / (MASS + inertia.high), rel=0.02)


def law(period: float, damping: float) -> MotionLaw:
    """The law of a part of 1 kg."""
    model = block()
    effect = placed(model, "flexible_mode", "rail").effect
    values = {"inertia": np.ones(1), "period": np.full(1, period), "damping": np.full(1, damping)}
    found = effect.force_law("rail", values, [model.nominal()])  # pyright: ignore[reportAttributeAccessIssue]
    assert isinstance(found, MotionLaw)
    return found


@pytest.mark.parametrize(("period", "damping"), [(0.15, 0.05), (0.4, 0.06), (1.5, 0.2)])
def test_the_past_of_a_window_tells_how_the_part_swings(period: float, damping: float) -> None:
    """A link that has long moved as A sin Ωt: δ is the steady answer of a driven oscillator.

    That velocities are means over intervals h costs (ω h)²/12 of δ, which the steps before the window let fade.
    """
    found, omega, drive, size = law(period, damping), 2 * np.pi / period, 2 * np.pi * 1.7, 0.3
    far = -NEAR * STEP - INTERVAL * np.arange(FAR, -1, -1)
    found.follow(np.diff(size * np.sin(drive * far))[None, :, None] / INTERVAL, INTERVAL)
    near = STEP * (np.arange(-NEAR, 0) + 0.5)
    found.follow((size * drive * np.cos(drive * near))[None, :, None], STEP)

    answer = size * drive**2 / (omega**2 - drive**2 + 2j * damping * omega * drive)  # δ = Im(answer e^{iΩt})
    distance, rate = answer.imag, (1j * drive * answer).imag
    real, imaginary, _ = found.memory[0]
    expected = rate + damping * omega * distance, omega * np.sqrt(1 - damping**2) * distance
    np.testing.assert_allclose([real, imaginary], expected, rtol=0, atol=0.03 * abs(drive * answer))


def test_far_past_and_near_past_are_one_motion() -> None:
    """A history by longer intervals ends where the same one by steps does, wherever it is cut."""
    speed = np.repeat(np.random.default_rng(3).normal(size=60), 5)
    cut, whole = law(0.5, 0.1), law(0.5, 0.1)
    cut.follow(speed[None, :200:5, None], 5 * STEP)
    cut.follow(speed[None, 200:, None], STEP)
    whole.follow(speed[None, :, None], STEP)
    np.testing.assert_allclose(cut.memory, whole.memory, rtol=1e-9)


def test_a_window_begins_with_what_swung_before() -> None:
    """The link stands still, but the part still swings from how it was moved long before the window."""
    model = block()
    extended = model.with_effect(placed(model, "flexible_mode", "rail"))
    period, size = 0.5, 0.2
    values = {"inertia": 0.5, "period": period, "damping": 0.003}
    z = extended.space.vector({f"flexible_mode@rail.{key}": value for key, value in values.items()})
    far = np.zeros((1, FAR, 1))
    far[0, -1] = size / INTERVAL  # the link jumped by 0.2 m just before the near past
    still = np.zeros((1, NEAR, 1))
    history = History(np.zeros(1), still, still, still, far, INTERVAL)
    controls, rest = np.zeros((1, 50, 1)), np.zeros((1, 1, 1))
    simulator = Simulator(extended, 1, threads=1)
    place = simulator.replay(z[None], rest, rest, controls, controls[:, :1], history).qpos[0, :, 0]
    omega, ago = 2 * np.pi / period, NEAR * STEP
    force = -0.5 * omega**2 * size * np.cos(omega * ago)  # J ω² δ with δ = −size cos ωt
    expected = 0.5 * force / MASS * (5 * STEP) ** 2
    assert place[5] == pytest.approx(expected, rel=0.15)
