"""A task of one's own that breaks its contract is told so, by method and shape, and not as a fault of dr_lab."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import mujoco
import numpy as np
import pytest
from block_on_rail import BlockOnRail, constant
from numpy.typing import NDArray

from dr_lab.collectors.play import play
from dr_lab.envs.episodes import Episodes
from dr_lab.envs.setting import Setting
from dr_lab.envs.task import Change, Fields, Values
from dr_lab.envs.task_outputs import ReadFields
from dr_lab.errors import ConfigError, DrLabError
from dr_lab.physics.model import from_spec
from dr_lab.trajectory import Array

XML = """<mujoco><option timestep="0.01"/><worldbody><body name="block">
  <geom type="sphere" size="0.1" mass="2"/><joint name="rail" type="slide" axis="1 0 0"/>
</body></worldbody><actuator><motor name="drive" joint="rail" ctrlrange="-3 3"/></actuator></mujoco>"""
ROWS = 3


@dataclass(frozen=True, kw_only=True)
class Block(BlockOnRail):
    """What each method gives is passed through a function of the test."""

    changed: ClassVar[dict[str, Callable[[Any], Any]]] = {}

    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        return self._changed("start", super().start(rng, compiled))

    def observe(self, fields: Fields, values: Values) -> Array:
        del values
        return self._changed("observe", np.column_stack([fields["qpos"], fields["qvel"]]))

    def controls(self, action: Array, values: Values) -> Array:
        del values
        return self._changed("controls", action)

    def reward(self, change: Change) -> Array:
        return self._changed("reward", -np.abs(change.fields["qpos"][:, 0]))

    def terminated(self, fields: Fields, values: Values) -> NDArray[np.bool_]:
        del values
        return self._changed("terminated", np.zeros(len(fields["qpos"]), bool))

    def _changed(self, method: str, values: Any) -> Any:  # noqa: ANN401  some break the contract
        return self.changed.get(method, lambda given: given)(values)


def episodes(method: str, change: Callable[[Any], Any]) -> Episodes:
    task = Block(frame_skip=1, time_limit=9)
    object.__setattr__(task, "changed", {method: change})
    model = from_spec("block", mujoco.MjSpec.from_string(XML), {})
    return Episodes(model, task, None, ROWS, 0, show_context=False, infeasible_return=-9.0, speed_limit=np.inf)


@pytest.mark.parametrize(
    ("method", "change", "told"),
    [
        (
            "start",
            lambda given: (np.zeros(2), given[1]),
            r"Block\.start gives positions of shape \(2,\); expected \(1,\)",
        ),
        ("start", lambda given: (given[0], given[1] * np.nan), r"Block\.start gives velocities that are not finite"),
        (
            "observe",
            np.ravel,
            r"Block\.observe gives an array of shape \(6,\); expected \(3, o\), one row a simulation",
        ),
        (
            "observe",
            lambda given: given * np.nan,
            r"Block\.observe gives \[nan nan\] at positions \[.*\]; expected finite",
        ),
        (
            "reward",
            lambda given: given[:, None],
            r"Block\.reward gives an array of shape \(3, 1\); expected \(3,\), one a",
        ),
        ("reward", lambda given: float(given.mean()), r"Block\.reward gives an array of shape \(\); expected \(3,\)"),
        (
            "controls",
            lambda given: given[:, 0],
            r"Block\.controls gives an array of shape \(3,\); expected \(3, 1\), one row a simulation and one column a",
        ),
        (
            "controls",
            lambda given: given * np.nan,
            r"Block\.controls gives \[nan\] for action \[1\.\]; expected finite",
        ),
        ("reward", lambda given: given * np.nan, r"Block\.reward gives \[nan\] at positions"),
        ("terminated", lambda given: False, r"Block\.terminated gives an array of shape \(\); expected \(3,\)"),
        ("terminated", lambda given: 1.0 * given, r"Block\.terminated gives float64; expected bool"),
    ],
)
def test_what_a_task_gives_is_held_against_its_contract(method: str, change: Callable[[Any], Any], told: str) -> None:
    with pytest.raises(DrLabError, match=told):
        episodes(method, change).step(np.ones((ROWS, 1)))


def test_numbers_that_are_none_at_a_start_alone_are_told_there() -> None:
    """As 0 / 0 at rest, which nobody would see in the steps after it."""
    with pytest.raises(DrLabError, match=r"Block\.observe gives \[nan nan\]"):
        episodes("observe", lambda given: np.where(np.abs(given[:, 1:]) > 1e-3, given, np.nan))


def test_a_dataclass_field_that_hides_a_method_is_refused_when_the_environment_is_made() -> None:
    @dataclass(frozen=True, kw_only=True)
    class Going(Block):
        goal: tuple[float, float] = (1.0, 0.0)  # pyright: ignore[reportIncompatibleMethodOverride]

    model = from_spec("block", mujoco.MjSpec.from_string(XML), {})
    rest = {"name": "block", "model": model, "show_context": False, "infeasible_return": -9.0}
    assert Setting(task=Block(frame_skip=1, time_limit=9), **rest).time_limit == 9
    with pytest.raises(ConfigError, match=r"Going has a field 'goal', which hides the method Task\.goal; .*start, obs"):
        Setting(task=Going(frame_skip=1, time_limit=9), **rest)


def test_a_field_that_the_task_does_not_read_is_told_with_the_remedy() -> None:
    fields = ReadFields(qpos=np.zeros((ROWS, 1)), qvel=np.zeros((ROWS, 1)))
    with pytest.raises(
        DrLabError, match=r"There is no field 'site_xpos' in `reads` of the task.*Available: qpos, qvel"
    ):
        fields["site_xpos"]


def test_numbers_of_an_episode_that_has_ended_are_nobodys_business() -> None:
    ends = np.array([True, False, False])
    task = episodes("terminated", lambda given: ends)
    assert task.step(np.ones((ROWS, 1))).done.tolist() == ends.tolist()
    object.__setattr__(task.task, "changed", {"reward": lambda given: np.where(ends, np.nan, given)})
    assert np.isfinite(task.step(np.ones((ROWS, 1))).reward).tolist() == [False, True, True]


def test_what_a_task_gives_may_be_a_part_of_a_field() -> None:
    """MuJoCo writes into fields at every step; what the policy saw, what was earned and where it was before stay."""

    class Bare(BlockOnRail):
        def marker(self, fields: Fields) -> Array:
            return fields["qpos"]

        def observe(self, fields: Fields, values: Values) -> Array:
            del values
            return fields["qvel"]

        def reward(self, change: Change) -> Array:
            np.testing.assert_allclose(change.velocity, change.fields["qvel"])
            return change.fields["qvel"][:, 0]

    model, task = from_spec("block", mujoco.MjSpec.from_string(XML), {}), Bare(frame_skip=1, time_limit=4)
    slots = Episodes(model, task, None, ROWS, 0, show_context=False, infeasible_return=-9.0, speed_limit=np.inf)
    played = play(slots, constant(1.0), np.zeros((ROWS, 0)))
    speeds = np.tile(0.005 * np.arange(1.0, 5.0)[:, None], (ROWS, 1, 1))  # 1 N moves 2 kg for steps of 0.01 s
    for seen in ("observation", "reward", "qvel"):
        np.testing.assert_allclose(played["next", seen], speeds, rtol=1e-6)
    before = slots.observation
    slots.step(np.ones((ROWS, 1)))
    np.testing.assert_array_equal(before, speeds[:, -1])
