"""A policy needs a range to act in."""

import mujoco
import numpy as np
import pytest
from block_on_rail import BlockOnRail

from dr_lab.envs.episodes import Episodes
from dr_lab.envs.task import Change, Fields, Values
from dr_lab.errors import ConfigError, ModelError
from dr_lab.physics.model import from_spec
from dr_lab.trajectory import Array

XML = """<mujoco model="block"><worldbody><body name="block">
  <inertial mass="2" pos="0 0 0" diaginertia="1 1 1"/><joint name="rail" type="slide" axis="1 0 0"/>
</body></worldbody><actuator>
  <motor name="drive" joint="rail" ctrlrange="-9 9"/><motor name="brake" joint="rail"/>
</actuator></mujoco>"""


class Still(BlockOnRail):
    def observe(self, fields: Fields, values: Values) -> Array:
        del values
        return fields["qpos"].copy()

    def reward(self, change: Change) -> Array:
        return np.zeros(len(change.action))


def episodes(task: Still) -> Episodes:
    model = from_spec("block", mujoco.MjSpec.from_string(XML), {})
    return Episodes(model, task, None, 2, 0, show_context=False, infeasible_return=0.0, speed_limit=np.inf)


def test_an_actuator_without_ctrlrange_is_refused_by_name() -> None:
    with pytest.raises(ModelError, match=r"could act in: brake \[0, 0\]; expected .* Give them a ctrlrange"):
        episodes(Still(frame_skip=1, time_limit=5))


def bounded(low: list[float], high: list[float]) -> Still:
    """A task with actions of its own, as a user may write it."""

    class Bounded(Still):
        def action_bounds(self, compiled: mujoco.MjModel) -> tuple[Array, Array]:
            del compiled
            return low, high  # pyright: ignore[reportReturnType]

    return Bounded(frame_skip=1, time_limit=5)


def test_bounds_of_a_task_s_own_are_held_against_the_contract() -> None:
    np.testing.assert_array_equal(episodes(bounded([-1.0, 0.0], [1.0, 2.0])).high, [1.0, 2.0])
    with pytest.raises(ModelError, match=r"could act in: action 2 \[0, 0\]; expected .* Mend action_bounds of Bounded"):
        episodes(bounded([-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]))  # more actions than actuators
    with pytest.raises(ConfigError, match=r"Bounded\.action_bounds gives arrays of shapes \(2,\) and \(3,\); expected"):
        episodes(bounded([-1.0, -1.0], [1.0, 1.0, 1.0]))
    with pytest.raises(ConfigError, match=r"Bounded\.controls gives an array of shape \(2, 1\); expected \(2, 2\)"):
        episodes(bounded([-1.0], [1.0])).step(np.ones((2, 1)))
