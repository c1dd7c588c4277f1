"""A goal is part of the context: the task sees it, it is drawn, recorded and carried like the machine's parameters."""

from dataclasses import dataclass

import mujoco
import numpy as np
import pytest
import torch
from block_on_rail import BlockOnRail, constant
from numpy.typing import NDArray

from dr_lab.collectors.lean import LeanCollector
from dr_lab.collectors.play import play
from dr_lab.envs.setting import Setting
from dr_lab.envs.task import Change, Fields, Values
from dr_lab.errors import ModelError
from dr_lab.physics.model import from_spec
from dr_lab.physics.parameter import Parameter
from dr_lab.randomizers.uniform import UniformRandomizer
from dr_lab.training.recorded import record
from dr_lab.trajectory import Array

DT, FORCE, LIMIT = 0.01, 3.0, 30
XML = f"""<mujoco><option timestep="{DT}" integrator="Euler"/><worldbody><body name="block">
  <geom name="cube" type="sphere" size="0.1" mass="2"/><joint name="rail" type="slide" axis="1 0 0"/>
</body></worldbody><actuator><motor name="drive" joint="rail" ctrlrange="-{FORCE} {FORCE}"/></actuator></mujoco>"""
MASS = {"cube.mass": {"target": "geom.cube.mass", "unit": "kg", "low": 1.0, "high": 4.0}}


@dataclass(frozen=True, kw_only=True)
class Reach(BlockOnRail):
    """The distance to the goal costs; reaching it ends the episode. The goal is seen, as the way to it."""

    named: str = "goal.x"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return (Parameter(self.named, "m", 1.0, 0.0, 2.0),)

    def observe(self, fields: Fields, values: Values) -> Array:
        return np.column_stack([values[self.named] - fields["qpos"][:, 0], fields["qvel"]])

    def reward(self, change: Change) -> Array:
        return -np.abs(change.values[self.named] - change.fields["qpos"][:, 0])

    def terminated(self, fields: Fields, values: Values) -> NDArray[np.bool_]:
        return fields["qpos"][:, 0] >= values[self.named]


def reach(goal: str = "goal.x", *, show_context: bool = False) -> Setting:
    model = from_spec("block", mujoco.MjSpec.from_string(XML), MASS)
    task = Reach(frame_skip=1, time_limit=LIMIT, named=goal)
    return Setting(name="reach", model=model, task=task, show_context=show_context, infeasible_return=-99.0)


push = constant(FORCE)


def test_every_episode_has_the_goal_and_the_machine_of_its_context() -> None:
    found = reach(show_context=True)
    assert found.space.names == ("cube.mass", "goal.x")
    z = np.array([[2.0, 2.0], [1.0, 0.05], [4.0, 1.0]])
    played = play(found.make(None, 2, 0, threads=1).episodes, push, z)
    x = 0.5 * FORCE / z[:, :1] * DT**2 * np.arange(1, LIMIT + 1) * np.arange(2, LIMIT + 2)
    lengths = [LIMIT, int(np.argmax(x[1] >= 0.05)) + 1, LIMIT]
    assert played["mask"].sum(1).tolist() == lengths  # pyright: ignore[reportOptionalMemberAccess]
    for row, length in enumerate(lengths):
        reward = played["next", "reward"][row, :length, 0]
        np.testing.assert_allclose(reward, -np.abs(z[row, 1] - x[row, :length]))
        torch.testing.assert_close(played["observation"][row, 0], torch.tensor([z[row, 1], 0.0, *unit(z[row])]).float())


def unit(z: Array) -> Array:
    return (z - [1.0, 0.0]) / [3.0, 2.0]


def test_goals_are_drawn_collected_and_recorded() -> None:
    found = reach()
    env = found.make(UniformRandomizer(found.space, {"cube.mass": [1.9, 2.1]}), 8, 0, threads=1)
    batch = next(LeanCollector(env, push, 40))
    goals = batch["context"][:, 0, 1]
    torch.testing.assert_close(batch["observation"][:, 0, 0], goals)
    assert goals.std() > 0.2
    (episode,) = record(found, found.make(None, 1, 0, threads=1).episodes, push, np.array([[2.0, 0.5]]))
    assert episode.context == {"cube.mass": (2.0, "kg"), "goal.x": (0.5, "m")}


def test_a_name_that_the_machine_has_is_refused() -> None:
    with pytest.raises(ModelError, match=r"both model 'block' and task Reach have: cube\.mass"):
        _ = reach(goal="cube.mass").space
