"""A longer link and a cable between joints, by Lagrange's equations and SciPy, are found again beside wrong masses."""

from collections.abc import Callable, Mapping
from itertools import pairwise

import mujoco
import numpy as np
import pytest
from diagnosis_machines import NOISE, STEP, clock, measured, solver_settings, steps_command, windows_settings
from effect_machines import CONF, catalogue_effect, scales_of
from paper_elbow import on_paper
from scipy.integrate import solve_ivp

from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.windows.windows import cut
from dr_lab.effects.effect import place
from dr_lab.physics.model import Model, load
from dr_lab.trajectory import Array, Log, Signal

SECONDS, UPPER, FORE, DAMPING = 3.0, 1.0, 0.55, (0.08, 0.05)  # s; true masses, kg; N·m·s/rad
FREE = {
    f"{body}.mass": {"target": f"body.{body}.mass", "unit": "kg", "low": 0.1, "high": 4.0}
    for body in ("upper_arm", "forearm")
}
Force = Callable[[Array], Array]


def none(position: Array) -> Array:
    return np.zeros_like(position)


def cable(position: Array) -> Array:
    """A cable that crosses from a pulley of 40 mm to one of 20 mm, 800 N/m, 5 mm longer than at the zero positions."""
    pull = 800.0 * (0.04 * position[0] + 0.02 * position[1] - 0.005)
    return np.array([-0.04 * pull, -0.02 * pull])


def hose(position: Array) -> Array:
    """A hose of 0.3 m and 15 N/m from a point beside the shoulder to the forearm's centre; slack where that is near."""
    turned = np.array([position[0], position.sum()])
    levers = np.array([0.3, 0.16]) * np.array([np.sin(turned), -np.cos(turned)])  # (x, z) of both links
    way = np.array([0.35, 0.9]) - np.array([0.0, 0.8]) - levers.sum(1)
    far = float(np.linalg.norm(way))
    pull = 15.0 * max(0.0, far - 0.3) * way / far
    turning = [levers.sum(1), levers[:, 1]]  # of the forearm's centre about either joint
    return np.array([pull @ [-z, x] for x, z in turning])


def log(name: str, seed: int, length: float, force: Force) -> Log:
    """Encoders of the arm under random steps of both torques."""
    arm, time = on_paper(length, UPPER, FORE, DAMPING), clock(round(SECONDS / STEP))
    commands = [steps_command("shoulder", 3.0, SECONDS, seed), steps_command("elbow", 1.0, SECONDS, 50 + seed)]
    positions, state = np.empty((len(time), 2)), np.array([0.4, 0.6, 0.0, 0.0])
    edges = [*commands[0].time, SECONDS]
    for k, (begin, end) in enumerate(pairwise(edges)):
        torque = np.array([command.value[k] for command in commands])

        def slope(_: float, y: Array, torque: Array = torque) -> Array:
            own = np.asarray(arm.own_force(y[:2].tolist(), y[2:].tolist()))
            total = torque + own + force(y[:2]) - np.asarray(DAMPING) * y[2:]
            gained = np.linalg.solve(np.asarray(arm.mass(y[:2].tolist())), total)
            return np.concatenate([y[2:], np.asarray(gained, np.float64)])

        inside = (time >= begin - 1e-9) & (time < end - 1e-9)
        solved = solve_ivp(slope, (begin, end), state, t_eval=[*np.clip(time[inside], begin, end), end], rtol=1e-8)
        positions[inside], state = solved.y[:2, :-1].T, solved.y[:, -1]
    seen = positions + NOISE * np.random.default_rng(1000 + seed).normal(size=positions.shape)
    names = ("shoulder.position", "elbow.position")
    joints = {each: Signal(each, "rad", time, seen[:, k]) for k, each in enumerate(names)}
    return Log(name, joints, {command.name: command for command in commands})


def model() -> Model:
    plain = load("elbow", CONF / "model" / "strangers" / "elbow.xml", FREE)
    plain.spec.option.timestep, plain.spec.option.integrator = STEP, mujoco.mjtIntegrator.mjINT_RK4
    return plain


@pytest.mark.parametrize(
    ("name", "site", "length", "force", "truth"),
    [
        ("link_length", "forearm", 0.325, none, {"excess": 0.025}),
        pytest.param(
            "joint_coupling",
            "elbow",
            0.3,
            cable,
            {"stiffness": 800.0 * 0.04**2, "ratio": -0.5, "rest": 0.125},
            marks=pytest.mark.slow,
        ),
        pytest.param(
            *("cable_force", "forearm", 0.3, hose),
            {"stiffness": 15.0, "anchor_x": 0.35, "anchor_z": 0.9, "length": 0.3},
            marks=pytest.mark.slow,  # a minute: four starts, and kinks where the hose slackens
        ),
    ],
)
def test_the_arm_is_found(name: str, site: str, length: float, force: Force, truth: Mapping[str, float]) -> None:
    plain = model()
    logs = [log("a", 0, length, force), log("b", 1, length, force)]
    one = place(catalogue_effect(name), plain.nominal(), site, scales_of(plain, torque=3.0))
    extended = plain.with_effect(one)
    windows = cut(logs, measured(logs), plain.nominal(), windows_settings())
    fitter = Fitter(Replay(extended, windows, 1), solver_settings())
    fits = [fitter.run(extended.space.vector(start)) for start in one.starts or ({},)]
    fit = min(fits, key=lambda each: each.cost)
    assert fit.cost / fitter.replay.fitted.sum() == pytest.approx(1.0, abs=0.15)
    expected = {"upper_arm.mass": UPPER, "forearm.mass": FORE, **{f"{one.label}.{k}": v for k, v in truth.items()}}
    for key, value in extended.space.mapping(fit.z).items():
        assert value == pytest.approx(expected[key], rel=0.05, abs=0.02), key
