"""Recorded logs as a target: known motions come back on the task's clock."""

from dataclasses import replace

import numpy as np
import pytest
from settings import setting

from dr_lab.errors import ConfigError
from dr_lab.targets.logs import LogsTarget
from dr_lab.trajectory import Log, MeasurementSet, Signal

STEP, STEPS = 0.01, 60  # s, of the task


def log(name: str, seconds: float) -> Log:
    """arm = 0.3 sin 5t and pole = t − t², measured every 2 ms; the voltage is 1 V at 0 s, 3 V from 15 ms on."""
    at = np.arange(0.0, seconds, 0.002)
    outputs = {"arm": 0.3 * np.sin(5 * at), "pole": at - at**2}
    command = Signal("motor", "V", np.array([0.0, 0.015]), np.array([1.0, 3.0]))
    signals = {f"{joint}.position": Signal(f"{joint}.position", "rad", at, q) for joint, q in outputs.items()}
    return Log(name, signals, {"motor": command})


def target(
    *logs: Log,
    env: str = "furuta",
    half_width: float = 0.01,
    stretch: float | None = None,
    held_out: tuple[Log, ...] = (),
) -> LogsTarget:
    measured = MeasurementSet("m", logs, held_out, {}, {})
    return LogsTarget(setting(env, f"env.task.time_limit={STEPS}"), measured, half_width, stretch)


def test_a_log_comes_back_as_an_episode() -> None:
    played = target(log("long", 2.0), log("short", 0.305)).play(None, None, 2)
    assert played.shape == (2, STEPS)
    assert played["mask"].sum(1).tolist() == [STEPS, 30]  # pyright: ignore[reportOptionalMemberAccess]
    at = STEP * np.arange(STEPS)
    qpos = np.column_stack([0.3 * np.sin(5 * at), at - at**2])
    qvel = np.column_stack([1.5 * np.cos(5 * at), 1.0 - 2.0 * at])
    np.testing.assert_allclose(played["qpos"][0], qpos, atol=1e-5)
    np.testing.assert_allclose(played["qvel"][0], qvel, atol=1e-3)
    np.testing.assert_allclose(played["next", "qpos"][1, :29], qpos[1:30], atol=1e-5)
    np.testing.assert_allclose(played["action"][0, :3, 0], [1.0, 2.0, 3.0])  # held, and changed amid the second step
    assert played["next", "truncated"][0, -1]


def test_a_command_that_goes_straight_between_its_samples_is_averaged_so() -> None:
    ramp = log("ramp", 2.0)
    straight = Signal("motor", "V", np.array([0.0, 0.02, 0.04]), np.array([1.0, 3.0, 2.0]), "line")
    played = target(replace(ramp, commands={"motor": straight})).play(None, None, 1)
    np.testing.assert_allclose(played["action"][0, :5, 0], [1.5, 2.5, 2.75, 2.25, 2.0])


def test_stretches_follow_one_another_and_are_spread_over_the_fitted_logs() -> None:
    made = target(log("long", 1.0), log("short", 0.35), stretch=0.2, held_out=(log("unseen", 9.0),))
    played = made.play(None, None, 5)  # four and one; what is left of a log is dropped
    assert played["mask"].sum(1).tolist() == [20] * 5  # pyright: ignore[reportOptionalMemberAccess]
    begins = np.array([0.0, 0.2, 0.4, 0.6, 0.0])
    np.testing.assert_allclose(played["qpos"][:, 0, 1], begins - begins**2, atol=1e-5)
    np.testing.assert_allclose(made.play(None, None, 2)["qpos"][:, 0], played["qpos"][[0, 2], 0])
    with pytest.raises(ConfigError, match=r"6 episodes .* has 5"):
        made.play(None, None, 6)
    with pytest.raises(ConfigError, match=r"lasts 2 s"):
        target(log("short", 0.305), env="furuta", stretch=2.0).play(None, None, 1)


def test_a_log_as_long_as_a_stretch_is_one() -> None:
    assert len(target(log("short", 0.291), stretch=0.29).play(None, None, 1)[0]) == 29  # it ends at 0.29 s


def test_a_log_whose_channels_do_not_overlap_holds_no_episode() -> None:
    late = log("late", 1.0)
    pole = late.outputs["pole.position"]
    apart = replace(late, outputs={**late.outputs, pole.name: replace(pole, time=pole.time + 2.0)})
    with pytest.raises(ConfigError, match=r"lasts a control step from where all .* have begun to where the first"):
        target(apart)
    assert len(target(apart, log("whole", 1.0)).play(None, None, 1)) == 1


@pytest.mark.parametrize("number", [-1.0, 0.0, np.nan, np.inf])
def test_a_length_that_is_none_is_refused(number: float) -> None:
    with pytest.raises(ConfigError, match=rf"target\.stretch is {number:g}; expected"):
        target(log("a", 1.0), stretch=number)
    with pytest.raises(ConfigError, match=rf"target\.half_width is {number:g}; expected"):
        target(log("a", 1.0), half_width=number)


def test_what_the_task_cannot_do_is_refused() -> None:
    strong = log("strong", 1.0)
    strong.commands["motor"].value[1] = 5.0  # V; the task has 4
    with pytest.raises(ConfigError, match=r"commanded from 1 to 5; .* from -4 to 4"):
        target(strong)
    with pytest.raises(ConfigError, match="ends an episode at once"):
        target(log("hanging", 1.0), env="furuta_balance")


def test_it_cannot_be_driven() -> None:
    with pytest.raises(ConfigError, match="cannot be driven"):
        target(log("a", 1.0)).play(lambda observation: observation[:, :1], None, 1)
    with pytest.raises(ConfigError, match=r"2 episodes .* has 1"):
        target(log("a", 1.0)).play(None, None, 2)


def test_measurements_of_another_machine_are_refused() -> None:
    other = Log("other", {"pendulum.position": log("a", 1.0).outputs["arm.position"]}, {})
    with pytest.raises(ConfigError, match=r"Log other of .* has pendulum\.position; expected arm\.position, pole"):
        target(other)
