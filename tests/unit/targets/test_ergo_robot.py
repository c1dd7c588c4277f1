"""The robot that stands for the thesis' one: slower, weaker, with play and friction, of which only motions are told."""

from functools import cache
from typing import cast

import numpy as np
import pytest
from hydra.utils import instantiate
from settings import setting
from torch import Tensor

from dr_lab.cli.compose import compose
from dr_lab.targets.target import Target
from dr_lab.trajectory import Array

COUNT, STEPS = 2, 60
STARTS = np.tile([0.0, 0.0, 0.0, -1.5, 0.1, 0.5], (COUNT, 1)), np.zeros((COUNT, 6))


def robot() -> Target:
    cfg = compose("evaluate", ["experiment=ergo_robot"])
    return instantiate(cfg.evaluator.target, _convert_="all")(setting("ergo_reacher"))


def commands() -> Array:
    """motor_6 turns as far as it can; then all move to and fro."""
    asked = np.zeros((COUNT, STEPS, 4))
    asked[:, :30, 3] = 1.5
    asked[:, 30:] = 0.4 * np.sign(np.sin(np.arange(30) / 3.0))[:, None]
    return asked


@cache
def motions() -> tuple[Array, Array]:
    """Positions and velocities of robot and model after each step, shape (2, COUNT, STEPS, nv)."""
    asked, nominal = commands(), setting("ergo_reacher").make(None, COUNT, 0, threads=1).episodes
    played = robot().play(asked, STARTS, COUNT)
    there = tuple(cast(Tensor, played["next", key]).numpy() for key in ("qpos", "qvel"))
    nominal.begin(np.arange(COUNT), STARTS)
    here = []
    for step in range(STEPS):
        nominal.step(asked[:, step])
        here.append(nominal.state)
    qpos, qvel = (np.stack(each, axis=1) for each in zip(*here, strict=True))
    return np.stack([there[0], qpos]), np.stack([there[1], qvel])


@pytest.mark.slow
def test_it_moves_otherwise_than_the_model() -> None:
    (there, here), _ = motions()
    assert np.abs(there - here)[:, :, :4].max() > 0.05
    np.testing.assert_allclose(there[:, :, 4:], here[:, :, 4:], atol=1e-9)  # goals lie where they lay


def test_it_is_slower() -> None:
    _, velocities = motions()
    there, here = velocities[:, :, :30, 3].max(axis=(1, 2))
    assert there == pytest.approx(11.9, rel=0.05)
    assert here == pytest.approx(18.0, rel=0.05)


def test_it_gives_motions_alone() -> None:
    target = robot()
    assert [name for name in dir(target) if not name.startswith("_")] == ["drivable", "nature", "play"]
    played = target.play(commands(), STARTS, COUNT)
    keys = {key if isinstance(key, str) else key[-1] for key in played.keys(True, True)}
    known = {"observation", "action", "mask", "qpos", "qvel", "reward", "terminated", "truncated", "done", "infeasible"}
    assert keys == known
