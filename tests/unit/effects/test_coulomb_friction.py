import mujoco
import numpy as np
import pytest
from effect_machines import NAMES, block, catalogue_effect, hanging, motion, placed, with_effect

from dr_lab.effects.dry_friction import DryFrictionEffect
from dr_lab.physics.model import from_spec
from dr_lab.trajectory import Array

MASS, STIFFNESS, TORQUE, START = 2.0, 200.0, 8.0, 0.37
# step in s, and RMS error in m over five half swings of ±0.37 m
INTEGRATORS = pytest.mark.parametrize(
    ("integrator", "timestep", "error"), [("RK4", 0.002, 6e-4), ("implicitfast", 0.0005, 3e-4), ("Euler", 0.0005, 3e-4)]
)


def rubbing(integrator: str, timestep: float, stiffness: float = STIFFNESS) -> mujoco.MjModel:
    machine = block(joint=f'stiffness="{stiffness}"')
    machine.spec.option.timestep = timestep
    machine.spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    return with_effect(machine, "coulomb_friction", "rail", torque=TORQUE)


def half_cosines(time: Array) -> Array:
    """A block on a spring with dry friction: half cosines about ±torque/stiffness, each smaller by twice that."""
    rest, omega = TORQUE / STIFFNESS, np.sqrt(STIFFNESS / MASS)
    last = np.ceil((START - rest) / (2 * rest))  # half swings until the spring no longer overcomes friction
    half = np.minimum(np.floor(omega * time / np.pi), last)
    moving = (START - (2 * half + 1) * rest) * np.cos(omega * time - half * np.pi) + rest
    return (-1.0) ** half * np.where(half < last, moving, START - 2 * last * rest)


def error_of(model: mujoco.MjModel) -> float:
    time, position, _ = motion(model, 2.0, qpos=START).T
    return float(np.sqrt(np.mean((position - half_cosines(time)) ** 2)))


@INTEGRATORS
def test_swing_on_a_spring_is_half_cosines_and_stops(integrator: str, timestep: float, error: float) -> None:
    assert error_of(rubbing(integrator, timestep)) < error


def test_mujocos_default_constraint_is_ten_times_worse() -> None:
    model = rubbing("RK4", 0.002)
    hard = error_of(model)
    model.dof_solref[0], model.dof_solimp[0, :2] = (0.02, 1.0), (0.9, 0.95)
    assert error_of(model) > 10 * hard


@INTEGRATORS
def test_sticks_below_the_torque_and_slides_above_it(integrator: str, timestep: float, error: float) -> None:
    del error
    model = rubbing(integrator, timestep, stiffness=0.0)
    assert abs(motion(model, 1.0, ctrl=0.9 * TORQUE)[-1, 1]) < 1e-5
    time, _, speed = motion(model, 1.0, ctrl=1.5 * TORQUE).T
    np.testing.assert_allclose(speed, 0.5 * TORQUE / MASS * time, atol=1e-9)


def test_adds_to_friction_loss_and_keeps_the_authors_constraint() -> None:
    joint = 'frictionloss="1" solreffriction="0.05 1" solimpfriction="0.8 0.9 0.001 0.5 2"'
    compiled = with_effect(block(joint=joint), "coulomb_friction", "rail", torque=2.0)
    assert compiled.dof_frictionloss[0] == 3.0
    assert compiled.dof_solref[0].tolist() == [0.05, 1.0]


DRY = sorted(name for name in NAMES if isinstance(catalogue_effect(name), DryFrictionEffect))


@pytest.mark.parametrize(
    ("effect", "own", "hard"),
    [(name, 0.0, True) for name in DRY] + [(name, 0.2, False) for name in DRY if name != "soft_friction"],
)
def test_how_hard_the_constraint_is_depends_on_no_parameter(effect: str, own: float, hard: bool) -> None:
    """The nominal friction loss decides, wherever a fit takes it."""
    friction = {"target": "joint.hinge.frictionloss", "unit": "N·m", "low": 0.0, "high": 0.5}
    declared = from_spec("pendulum", hanging(f'frictionloss="{own}"').spec, {"friction": friction})
    model = declared.with_effect(placed(declared, effect, "hinge"))
    compiled = [model.compile(model.space.vector({"friction": value})) for value in (0.0, 5e-5, 0.3)]
    settings = [np.concatenate([each.dof_solref[0], each.dof_solimp[0]]) for each in compiled]
    np.testing.assert_array_equal(settings, [settings[0]] * 3)
    assert (settings[0][0] < 0) == hard
