"""Numbers that a task cannot be made of are refused by their own key, before anything is played."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from settings import setting

from dr_lab.__main__ import main
from dr_lab.envs.task import required_bounds
from dr_lab.envs.tasks.drawer import DrawerWeights
from dr_lab.errors import ConfigError, ModelError

INF, NAN = np.inf, np.nan
ONE_PLACE = [[0.4, -1.0]]


@pytest.mark.parametrize(
    ("env", "name", "value", "expected"),
    [
        ("hopper", "height_range", [0.7], "[lowest, highest], lowest < highest"),
        ("hopper", "height_range", [2.0, 1.0], "[lowest, highest], lowest < highest"),
        ("hopper", "start_noise", -1.0, "at least 0"),
        ("hopper", "start_noise", INF, "a finite number"),
        ("hopper", "velocity_limit", -1.0, "a number above 0"),
        ("hopper", "forward_weight", NAN, "a finite number"),
        ("ant", "contact_limit", 0.0, "a number above 0"),
        ("humanoid", "contact_cost_limit", -1.0, "at least 0"),
        ("furuta", "position_limit", [1.0], "2 numbers, each a number above 0"),
        ("furuta", "start_position", [-0.1, 0.1], "2 finite numbers, each at least 0"),
        ("furuta", "start_position", [0.1], "2 finite numbers, each at least 0"),
        ("furuta", "start_centre", [NAN, 0.0], "2 finite numbers"),
        ("furuta", "voltage", 0.0, "a number above 0"),
        ("drawer", "pose", [0.0, 0.0], "7 finite numbers"),
        ("drawer", "speeds", [1.0, 2.0], "7 finite numbers, each a number above 0"),
        ("drawer", "grasp", [0.1], "2 finite numbers, each a number above 0"),
        ("drawer", "scales", [0.5, 0.1], "[lowest, highest], lowest < highest"),
        ("pusher_3dof", "puck_range", ONE_PLACE, "[[x, y], [x, y]], least and largest"),
        ("pusher_3dof", "goal_range", [[1.2, -0.8], [0.8, -1.2]], "[[x, y], [x, y]], least and largest"),
        ("pusher_3dof", "effort", -1.0, "a number above 0"),
        ("ergo_pusher", "puck_range", ONE_PLACE, "[[x, y], [x, y]], which differ in both"),
        ("ergo_pusher", "goal_range", [[0.1, 0.0], [0.1, 0.2]], "[[x, y], [x, y]], which differ in both"),
        ("ergo_pusher", "speed", 0.0, "a number above 0"),
        ("ergo_reacher", "goal_height", -1.0, "a number above 0"),
        ("ergo_reacher", "goal_radius", [0.2, 0.1], "[lowest, highest], lowest < highest"),
        ("ergo_reacher", "goal_radius", [-0.2, 0.1], "2 finite numbers, each at least 0"),
    ],
)
def test_a_number_out_of_its_bounds_is_told(env: str, name: str, value: Any, expected: str) -> None:  # noqa: ANN401
    with pytest.raises(ConfigError) as told:
        replace(setting(env).task, **{name: value})
    given = f"{value:g}" if isinstance(value, float) else str(value)
    assert str(told.value) == f"env.task.{name} is {given}; expected {expected}."


def test_limits_may_be_none() -> None:
    replace(setting("furuta").task, position_limit=[INF, INF], tilt_limit=INF)
    replace(setting("hopper").task, height_range=[-INF, INF], velocity_limit=INF)


@pytest.mark.parametrize("value", [INF, NAN])
def test_a_return_of_infeasible_episodes_is_finite(value: float) -> None:
    with pytest.raises(ConfigError, match=rf"^env\.infeasible_return is {value:g}; expected a finite number\."):
        replace(setting("hopper"), infeasible_return=value)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"rail_range": [0.05, 0.09]}, r"rail_margin is 0\.05 m at either end; .* 0\.025 m"),
        ({"rail_margin": 2.0}, r"rail_margin is 2 m at either end; .* 0\.1625 m"),
    ],
)
def test_a_rail_that_its_margins_use_up_is_refused(changes: dict[str, Any], told: str) -> None:
    with pytest.raises(ConfigError, match=told):
        replace(setting("cartpole_domains").task, **changes)


@pytest.mark.parametrize(
    ("reward", "name", "value", "told"),
    [
        ("exponential", "error_weights", [1.0, 1.0], r"expected 4 numbers, for a reward of 4 errors and of 1 action\."),
        ("exponential", "action_weights", [1.0, 1.0], r"expected 1 number, for"),
        ("exponential", "error_weights", [-1.0, 1.0, 1.0, 1.0], "expected finite numbers, each at least 0"),
        ("shared", "limits", [1.0], "expected 5 numbers"),
        ("shared", "scales", [0.0, 1.0, 1.0, 1.0, 1.0], "expected finite numbers, each a number above 0"),
    ],
)
def test_a_reward_of_another_machine_is_refused(reward: str, name: str, value: list[float], told: str) -> None:
    task: Any = setting("furuta", f"env/reward=furuta/{reward}").task
    with pytest.raises(ConfigError, match=rf"^env\.task\.reward_of\.{name} is .*; {told}"):
        replace(task, reward_of=replace(task.reward_of, **{name: value}))


def test_a_weight_of_the_drawer_is_a_number() -> None:
    with pytest.raises(ConfigError, match=r"^env\.task\.weights\.angle is nan; expected a finite number\."):
        DrawerWeights(distance=0.5, angle=NAN, opening=0.4, fingers=0.005, action=0.005)


def test_a_task_with_bounds_of_its_own_is_not_sent_to_the_model(monkeypatch: pytest.MonkeyPatch) -> None:
    """A task that leaves its policy nothing to do, whatever the model says."""
    task, compiled = setting("drawer").task, setting("drawer").model.nominal()
    nothing = np.zeros(compiled.nu)
    monkeypatch.setattr(type(task), "action_bounds", lambda *_: (nothing, nothing))
    with pytest.raises(ModelError, match=r"Mend action_bounds of \w+, or the numbers of env\.task that it takes\."):
        required_bounds(task, compiled)


def test_the_command_line_tells_all_of_them_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    typed = ["env=furuta", "env.task.position_limit=[1.0]", "env.task.voltage=0", f"hydra.run.dir={tmp_path / 'run'}"]
    assert main(["train", *typed]) != 0
    told = capsys.readouterr().err
    assert "env.task.position_limit is [1.0]; expected 2 numbers, each a number above 0." in told
    assert "env.task.voltage is 0; expected a number above 0." in told
    assert "Traceback" not in told


def test_weights_of_the_drawer_are_not_misspelt(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    typed = ["env=drawer", "+env.task.weights.distanc=0.5", f"hydra.run.dir={tmp_path / 'run'}"]
    assert main(["train", *typed]) != 0
    assert "Did you mean 'env.task.weights.distance'?" in capsys.readouterr().err
