"""A block that is pushed by a constant force: v = F t/m, exactly so for an explicit step, and x' one step behind."""

import mujoco
import numpy as np
import pytest
from block_on_rail import BlockOnRail, constant
from numpy.typing import NDArray
from tensordict import TensorDict

from dr_lab.collectors.collector import Drive
from dr_lab.collectors.play import outcomes, play
from dr_lab.envs.episodes import Episodes
from dr_lab.envs.setting import Setting
from dr_lab.envs.slots import EpisodeSlots
from dr_lab.envs.task import Change, Fields, Values
from dr_lab.physics.model import from_spec
from dr_lab.training import rollouts
from dr_lab.training.recorded import record
from dr_lab.training.rollouts import PolicyRollouts
from dr_lab.trajectory import Array

DT, LIMIT, FORCE = 0.01, 20, 3.0
XML = f"""<mujoco><option timestep="{DT}" integrator="Euler"/><worldbody><body name="block">
  <geom name="cube" type="sphere" size="0.1" mass="2"/><joint name="rail" type="slide" axis="1 0 0"/>
</body></worldbody><actuator><motor name="drive" joint="rail" ctrlrange="-{FORCE} {FORCE}"/></actuator></mujoco>"""
PARAMETERS = {"cube.mass": {"target": "geom.cube.mass", "unit": "kg", "low": -1.0, "high": 4.0}}


class Push(BlockOnRail):
    """Velocity is rewarded; the episode ends beyond 1 m/s."""

    def observe(self, fields: Fields, values: Values) -> Array:
        del values
        return fields["qvel"].copy()

    def reward(self, change: Change) -> Array:
        return change.fields["qvel"][:, 0].copy()

    def terminated(self, fields: Fields, values: Values) -> NDArray[np.bool_]:
        del values
        return fields["qvel"][:, 0] > 1.0


push = constant(10.0 * FORCE)  # cut off at FORCE


block = Setting(
    name="block",
    model=from_spec("block", mujoco.MjSpec.from_string(XML), PARAMETERS),
    task=Push(frame_skip=1, time_limit=LIMIT),
    show_context=False,
    infeasible_return=-7.0,
    speed_limit=200.0,
)


def episodes(count: int) -> Episodes:
    return block.make(None, count, 0, threads=1).episodes


def test_an_episode_holds_its_course_from_start_to_end() -> None:
    heavy, light = record(block, episodes(3), push, np.array([[4.0], [0.5]]))
    steps = np.arange(LIMIT + 1)
    velocity = FORCE / 4.0 * DT * steps
    np.testing.assert_allclose(heavy.time, DT * steps)
    np.testing.assert_allclose(heavy.qvel[:, 0], velocity)
    np.testing.assert_allclose(heavy.qpos[:, 0], DT * np.cumsum(velocity))
    np.testing.assert_allclose(heavy.reward, velocity[1:])
    assert (heavy.action == FORCE).all()
    assert heavy.ended == "truncated"
    assert heavy.context == {"cube.mass": (4.0, "kg")}
    assert heavy.geometry.body("block").mass[0] == pytest.approx(4.0)
    # 6 m/s² exceed 1 m/s in the 17th step; what the slot does then is not recorded
    assert (light.ended, len(light.reward)) == ("terminated", 17)
    assert light.qvel[-1, 0] == pytest.approx(1.02)
    assert [heavy.name, light.name] == ["episode_1", "episode_2"]


def test_an_infeasible_context_is_told_and_has_the_declared_return() -> None:
    (broken,) = record(block, episodes(1), push, np.array([[-1.0]]))
    assert broken.ended == "infeasible"
    assert broken.undiscounted == -7.0
    assert broken.geometry.body("block").mass[0] == pytest.approx(2.0)


def test_what_is_recorded_returns_what_is_returned() -> None:
    z = np.array([[0.5], [1.0], [4.0]])
    returns = PolicyRollouts(episodes(2), push).returns(z)
    np.testing.assert_allclose([each.undiscounted for each in record(block, episodes(3), push, z)], returns)


def test_of_many_episodes_no_more_are_kept_than_run_side_by_side(monkeypatch: pytest.MonkeyPatch) -> None:
    kept = list[int]()

    def counted(slots: EpisodeSlots, drive: Drive, z: Array) -> TensorDict:
        kept.append(len(z))
        return play(slots, drive, z)

    monkeypatch.setattr(rollouts, "play", counted)
    z = np.array([[0.5], [1.0], [-1.0], [2.0], [4.0]])
    returns, infeasible = PolicyRollouts(episodes(2), push).outcomes(z)
    assert kept == [2, 2, 1]
    wanted = outcomes(play(episodes(2), push, z))
    np.testing.assert_array_equal(returns, wanted[0])
    np.testing.assert_array_equal(infeasible, wanted[1])
