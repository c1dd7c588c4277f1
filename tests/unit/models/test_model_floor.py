"""The chosen integrator and step: their own error lies far below what any encoder resolves."""

import mujoco
import numpy as np
import pytest
from mujoco import rollout
from numpy.typing import NDArray

from dr_lab.cli.folders import shipped

RATE = 250  # Hz, commands
WINDOW = 0.3  # s


def commands(amplitude: float, seconds: float, nu: int) -> NDArray:
    """Random steps plus a sine at RATE, shape (k, nu)."""
    rng = np.random.default_rng(0)
    count = round(seconds * RATE)
    time = np.arange(count)[:, None] / RATE
    steps = np.repeat(rng.uniform(-amplitude / 2, amplitude / 2, (count // 25 + 1, nu)), 25, axis=0)[:count]
    return steps + amplitude / 2 * np.sin(2 * np.pi * rng.uniform(1, 4, nu) * time)


def positions(name: str, start: NDArray, control: NDArray, step: float | None) -> tuple[NDArray, NDArray]:
    """Positions and full states at the command rate, (windows, k, nq) and (windows, k, n)."""
    spec = mujoco.MjSpec.from_file(str(shipped() / "model" / f"{name}.xml"))
    spec.option.timestep = step or spec.option.timestep
    model = spec.compile()
    per = round(1 / RATE / model.opt.timestep)
    state, _ = rollout.rollout(model, mujoco.MjData(model), start, np.repeat(control, per, axis=1))
    return state[:, per - 1 :: per, 1 : 1 + model.nq], state[:, per - 1 :: per]


@pytest.mark.parametrize(
    ("name", "amplitude", "floor"),  # V, N m or N; rad or m
    [
        ("furuta", 6.0, 1e-7),  # encoder count 3.07e-3 rad
        ("cartpole", 6.0, 1e-8),
        ("pendulum", 3.0, 1e-8),
        ("double_pendulum_c1", 2.0, 1e-7),  # encoder count 3.8e-4 rad
        ("double_pendulum_a0", 2.0, 1e-7),
        ("emps", 200.0, 1e-12),  # encoder count 5e-8 m
        ("servo_xl330", 5.0, 1e-5),  # encoder count 1.53e-3 rad
        ("servo_sts3250", 1.0, 1e-4),
    ],
)
def test_quarter_of_the_step_changes_nothing_that_is_measured(name: str, amplitude: float, floor: float) -> None:
    model = mujoco.MjModel.from_xml_path(str(shipped() / "model" / f"{name}.xml"))
    control = commands(amplitude, 3.0, model.nu)
    begin = np.zeros((1, 1 + model.nq + model.nv))
    begin[0, 1 : 1 + model.nq] = 0.1
    _, run = positions(name, begin, control[None], None)
    length = round(WINDOW * RATE)
    cuts = np.arange(0, len(control) - length - 1, length)
    windows = np.stack([control[c + 1 : c + 1 + length] for c in cuts])
    start = run[0, cuts]
    coarse, _ = positions(name, start, windows, None)
    fine, _ = positions(name, start, windows, model.opt.timestep / 4)
    assert np.abs(coarse - fine).max() < floor
