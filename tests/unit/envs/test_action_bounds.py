"""A policy needs a range to act in."""

import mujoco
import numpy as np
import pytest
from block_on_rail import BlockOnRail

from dr_lab.envs.episodes import Episodes
from dr_lab.envs.task import Change, Fields, Values
from dr_lab.errors import ModelError
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


def test_an_actuator_without_ctrlrange_is_refused_by_name() -> None:
    model = from_spec("block", mujoco.MjSpec.from_string(XML), {})
    with pytest.raises(ModelError, match=r"could act in: brake \[0, 0\]; expected .* Give them a ctrlrange"):
        Episodes(
            model,
            Still(frame_skip=1, time_limit=5),
            None,
            1,
            0,
            show_context=False,
            infeasible_return=0.0,
            speed_limit=np.inf,
        )
