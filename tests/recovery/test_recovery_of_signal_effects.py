"""A sensor's filter and a driver's lag, solved by SciPy, are found again beside a wrong mass and damping."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import (
    NOISE,
    STEP,
    clock,
    formal_std,
    log_of,
    pendulum,
    simulated,
    solver_settings,
    steps_command,
    windows_of,
)
from effect_machines import placed
from scipy.signal import lsim

from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.trajectory import Array, Log, Signal

TRUTH = {"rod.mass": 0.6, "hinge.damping": 0.08}
SECONDS, FINE = 3.0, 4


def first_order(tau: float, time: Array, value: Array, *, held: bool) -> Array:
    """Solution of tau y' = u − y that starts at rest."""
    system = ([[-1 / tau]], [[1 / tau]], [[1.0]], [[0.0]])
    return np.asarray(lsim(system, value, time, X0=value[:1], interp=not held)[1])


def untouched(signal: Signal) -> Signal:
    return signal


def lagging(signal: Signal) -> Signal:
    """A command behind 8 ms of lag, in steps finer than the model's."""
    edges = clock(round(SECONDS / STEP) * FINE + 1, STEP / FINE)
    held = signal.value[np.searchsorted(signal.time, edges + 1e-9, side="right") - 1]
    output = first_order(8e-3, edges, held, held=True)
    return replace(signal, time=edges[:-1], value=(output[1:] + output[:-1]) / 2)


def exact(time: Array, position: Array) -> Array:
    del time
    return position


def filtered(time: Array, position: Array) -> Array:
    """A reading behind a filter of 4 ms."""
    return first_order(4e-3, time, position, held=False)


def log(seed: int, drive: Callable[[Signal], Signal], sensor: Callable[[Array, Array], Array]) -> Log:
    model, asked = pendulum(), steps_command("drive", 1.0, SECONDS, seed)
    motion = simulated(model.compile(model.space.vector(TRUTH)), drive(asked), SECONDS, qpos=[0.8], refine=FINE)
    noise = NOISE * np.random.default_rng(1000 + seed).normal(size=len(motion["time"]))
    reading = sensor(motion["time"], motion["qpos"][:, 0]) + noise
    return log_of(f"log_{seed}", {"hinge.position": (motion["time"], reading)}, asked)


@pytest.mark.parametrize(
    ("name", "site", "drive", "sensor", "truth"),
    [
        ("sensor_low_pass", "hinge", untouched, filtered, 4e-3),
        ("actuator_lag", "drive", lagging, exact, 8e-3),
    ],
)
def test_the_hidden_time_constant_is_found(
    name: str, site: str, drive: Callable[[Signal], Signal], sensor: Callable[[Array, Array], Array], truth: float
) -> None:
    plain = pendulum()
    logs = [log(seed, drive, sensor) for seed in range(2)]
    model = plain.with_effect(placed(plain, name, site))
    fitter = Fitter(Replay(model, windows_of(plain, logs), 1), solver_settings())
    fit = fitter.run(model.space.nominal)
    assert fit.cost / fitter.replay.fitted.sum() == pytest.approx(1.0, abs=0.1)
    std = formal_std(model, fit)
    found = model.space.mapping(fit.z)
    assert found[f"{name}@{site}.tau"] == pytest.approx(truth, rel=0.03)
    for value, error, true in zip(found.values(), std, (*TRUTH.values(), truth), strict=True):
        assert abs(value - true) < 4 * error
