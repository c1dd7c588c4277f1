"""Forces in an equation of motion that SciPy solves are found again, beside a wrong mass and damping."""

from collections.abc import Callable, Mapping

import numpy as np
import pytest
from diagnosis_machines import (
    NOISE,
    STEP,
    clock,
    formal_std,
    log_of,
    pendulum,
    solver_settings,
    steps_command,
    windows_of,
)
from effect_machines import placed
from scipy.integrate import solve_ivp

from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.trajectory import Array, Log

TRUTH = {"rod.mass": 0.6, "hinge.damping": 0.08}
SECONDS, LENGTH, SPREAD = 3.0, 0.3, 0.01  # s; m; m², inertia about the centre by mass
GRAVITY, CREEP = 9.81, 0.003  # m/s²; rad/s, within which dry friction builds up
Force = Callable[[float, float], float]


def asymmetric(position: float, speed: float) -> float:
    """−0.1 N·m forwards and half of it backwards."""
    del position
    return -0.075 * np.tanh(speed / CREEP) - 0.025


def cogging(position: float, speed: float) -> float:
    del speed
    return 0.1 * np.sin(12 * position) - 0.04 * np.cos(12 * position)


def log(seed: int, force: Force) -> Log:
    """A pendulum under random steps of torque and a hidden force."""
    command = steps_command("drive", 1.0, SECONDS, seed)
    mass, damping = TRUTH.values()
    inertia = mass * (SPREAD + LENGTH**2)
    time = clock(round(SECONDS / STEP))
    position, state = np.empty_like(time), np.array([0.8, 0.0])
    for begin, end, torque in zip(command.time, [*command.time[1:], SECONDS], command.value, strict=True):

        def slope(_: float, y: Array, torque: float = torque) -> list[float]:
            weight = mass * GRAVITY * LENGTH * np.sin(y[0])
            return [y[1], (torque - weight - damping * y[1] + force(*y)) / inertia]

        inside = (time >= begin - 1e-9) & (time < end - 1e-9)
        moments = np.append(np.clip(time[inside], begin, end), end)
        solved = solve_ivp(slope, (begin, end), state, method="LSODA", t_eval=moments, rtol=1e-8, atol=1e-10)
        position[inside], state = solved.y[0, :-1], solved.y[:, -1]
    reading = position + NOISE * np.random.default_rng(1000 + seed).normal(size=len(time))
    return log_of(f"log_{seed}", {"hinge.position": (time, reading)}, command)


@pytest.mark.parametrize(
    ("name", "force", "truth"),
    [
        ("asymmetric_friction", asymmetric, {"mean": 0.075, "asymmetry": 1 / 3}),
        ("cogging", cogging, {"sine": 0.1, "cosine": -0.04, "periods": 12.0}),
    ],
)
def test_the_hidden_force_is_found(name: str, force: Force, truth: Mapping[str, float]) -> None:
    plain = pendulum()
    logs = [log(seed, force) for seed in range(2)]
    one = placed(plain, name, "hinge")
    model = plain.with_effect(one)
    fitter = Fitter(Replay(model, windows_of(plain, logs), 1), solver_settings())
    fit = fitter.run(model.space.vector(one.starts[0] if one.starts else {}))
    assert fit.cost / fitter.replay.fitted.sum() == pytest.approx(1.0, abs=0.1)
    std = formal_std(model, fit)
    expected = {**TRUTH, **{f"{one.label}.{key}": value for key, value in truth.items()}}
    for (key, value), error in zip(model.space.mapping(fit.z).items(), std, strict=True):
        assert value == pytest.approx(expected[key], rel=0.05)
        assert abs(value - expected[key]) < 4 * error
