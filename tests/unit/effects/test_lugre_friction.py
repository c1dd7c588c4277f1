"""LuGre friction against closed forms, Stribeck friction and equations that another solver integrates."""

import numpy as np
import pytest
from effect_machines import block, placed, scales_of
from scipy.integrate import solve_ivp

from dr_lab.effects.effect import PlacedEffect
from dr_lab.effects.lugre_friction import LugreFriction
from dr_lab.physics.law import Influence, Moment
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

MASS = 2.0  # kg, of the block
STEP = 0.002
KINETIC, EXCESS, SPEED = 6.0, 4.0, 0.3  # N, N, m/s


def effect() -> PlacedEffect:
    return placed(block(), "lugre_friction", "rail", scales_of(block(), position=10.0, speed=20.0))


def moved(command: float | Array, *, way: float, retardation: float = 0.0, start: float = 0.0) -> tuple[Array, Array]:
    """Positions and speeds of the block, pushed by `command` in N and begun at a speed in m/s."""
    model = block().with_effect(effect())
    controls = (np.zeros(250) + command)[None, :, None]
    z, place = np.array([[KINETIC, EXCESS, SPEED, way, retardation]]), np.zeros((1, 1, 1))
    rollout = Simulator(model, 1, threads=1).replay(z, place, place + start, controls, controls[:, :1])
    return rollout.qpos[0, :, 0], rollout.qvel[0, :, 0]


def lugre(command: Array, way: float, retardation: float, start: float = 0.0) -> Array:
    """The block's positions by the equations as they were published, integrated by SciPy."""
    stiffness = (KINETIC + EXCESS) / way

    def rates(time: float, state: Array) -> list[float]:
        _, v, bent = state
        force = command[min(int(time / STEP + 1e-9), len(command) - 1)]
        steady = KINETIC + EXCESS * np.exp(-((v / SPEED) ** 2))
        bending = v - stiffness * abs(v) / steady * bent
        return [v, (force - stiffness * (bent + retardation * bending)) / MASS, bending]

    times = STEP * np.arange(len(command) + 1)
    found = solve_ivp(rates, (0.0, times[-1]), [0.0, start, 0.0], "LSODA", times, rtol=1e-8, atol=1e-10, max_step=STEP)
    return found.y[0]


@pytest.mark.parametrize(("way", "retardation"), [(0.002, 0.0), (0.002, 0.01), (0.02, 0.005)])
def test_it_moves_as_the_published_equations_say(way: float, retardation: float) -> None:
    """Through sticking, breaking loose and reversals; friction and command alone would take it 0.2 m."""
    command = 14.0 * np.sin(2 * np.pi * 4.0 * STEP * np.arange(250))
    truth = lugre(command, way, retardation)
    place, _ = moved(command, way=way, retardation=retardation)
    assert np.ptp(truth) > 0.01
    np.testing.assert_allclose(place, truth, rtol=0, atol=0.01 * np.ptp(truth))


def test_it_slides_steadily_as_stribeck_says() -> None:
    effect, bounds = catalogue(), placed(block(), "lugre_friction", "rail").parameters
    law = effect.force_law("rail", dict(zip(names(bounds), VALUES, strict=True)), [block().nominal()])
    speeds = np.array([0.1, 0.3, -0.5, 3.0])
    influence = still(speeds)
    for _ in range(2000):
        influence = still(speeds)
        law.act(moment(speeds), influence)
    expected = -np.sign(speeds) * (KINETIC + EXCESS * np.exp(-((speeds / SPEED) ** 2)))
    np.testing.assert_allclose(influence.force[:, 0], expected, rtol=1e-6)


def test_bristles_that_nothing_holds_at_high_speed_let_go() -> None:
    """Without kinetic friction Stribeck's curve ends at 0, there beyond what a number can hold."""
    values = {name: np.full(1, value) for name, value in NOTHING_KINETIC.items()}
    law, influence = catalogue().force_law("rail", values, [block().nominal()]), still(np.zeros(1))
    for speed in (0.2 * SPEED, 8 * SPEED, 8 * SPEED):
        influence = still(np.array([speed]))
        law.act(moment(np.array([speed])), influence)
    assert abs(influence.force[0, 0]) < 1e-6 * EXCESS


def test_bristles_that_do_not_bend_leave_stribeck_friction() -> None:
    stribeck = placed(block(), "stribeck_friction", "rail", scales_of(block(), position=10.0, speed=20.0))
    model, place = block().with_effect(stribeck), np.zeros((1, 1, 1))
    controls = 14.0 * np.sin(2 * np.pi * 3.0 * STEP * np.arange(250))
    rollout = Simulator(model, 1, threads=1).replay(
        np.array([[KINETIC, EXCESS, SPEED]]), place, place, controls[None, :, None], controls[None, :1, None]
    )
    hard = rollout.qpos[0, :, 0]
    soft, _ = moved(controls, way=1e-6)
    # The effect's clipped forces are up to 0.083 of the drop away from Stribeck's curve.
    assert np.abs(soft - hard).max() < 0.083 * np.ptp(hard)


def test_under_a_load_that_it_holds_it_bends_and_creeps_little() -> None:
    """As far as the published equations bend, and v_c artanh(F/T) of creep, which stands for none."""
    place, _ = moved(5.0, way=0.01, retardation=0.02)
    creep = catalogue().creep * SPEED * np.arctanh(5.0 / (KINETIC + EXCESS))
    truth = lugre(np.full(250, 5.0), 0.01, 0.02)
    np.testing.assert_allclose(place, truth, rtol=0, atol=1.1 * creep * 250 * STEP)
    assert np.ptp(truth) > 10 * creep * 250 * STEP


def test_without_any_friction_it_does_nothing() -> None:
    model, place = block().with_effect(effect()), np.zeros((1, 1, 1))
    controls = np.full((1, 100, 1), 3.0)
    z = np.array([[0.0, 0.0, SPEED, 0.01, 0.01]])
    rollout = Simulator(model, 1, threads=1).replay(z, place, place, controls, controls[:, :1])
    np.testing.assert_allclose(rollout.qvel[0, :, 0], 3.0 / MASS * STEP * np.arange(101), atol=1e-9)


NOTHING_KINETIC = {"kinetic": 0.0, "excess": EXCESS, "speed": SPEED, "displacement": 1e-3, "retardation": 0.0}
VALUES = tuple(np.full(4, value) for value in (KINETIC, EXCESS, SPEED, 0.01, 0.01))


def catalogue() -> LugreFriction:
    found = effect().effect
    assert isinstance(found, LugreFriction)
    return found


def names(parameters: tuple[Parameter, ...]) -> list[str]:
    return [p.name.rpartition(".")[2] for p in parameters]


def moment(speeds: Array) -> Moment:
    zero = np.zeros((len(speeds), 1))
    return Moment(STEP, np.zeros(len(speeds)), zero, speeds[:, None], zero, zero, zero)


def still(speeds: Array) -> Influence:
    return Influence(*(np.zeros((len(speeds), 1)) for _ in range(4)))
