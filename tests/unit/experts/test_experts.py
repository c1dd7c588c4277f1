"""Trajectories of experts: what a file of episodes or a target holds, and what is said of one that does not."""

from pathlib import Path

import numpy as np
import pytest
import torch
from tensordict import TensorDict

from dr_lab.errors import ConfigError, DataError
from dr_lab.experts import target as module
from dr_lab.experts.expert import Demonstrations
from dr_lab.experts.mcap import McapExpert
from dr_lab.recorders.mcap import FloatArrays, write_mcap
from dr_lab.trajectory import Array

LENGTHS = [3, 5, 2] + [4] * 8  # eleven episodes, so that episode_10 is to come after episode_9


def written(folder: Path, lengths: list[int] = LENGTHS, *, lost: int = 0) -> Path:
    """Episodes whose numbers say where they are from: 100 · episode + step, and ten times that for the action."""
    topics = []
    for number, steps in enumerate(lengths, start=1):
        seen = 100.0 * number + np.arange(steps + 1 - lost)[:, None] * np.ones(2)
        done = 10.0 * seen[:steps, :1] if not lost else 10.0 * np.ones((steps, 1))
        topics += [
            FloatArrays(f"/episode_{number}/observation", ("a", "b"), np.arange(len(seen), dtype=np.float64), seen),
            FloatArrays(f"/episode_{number}/action", ("u",), np.arange(steps, dtype=np.float64), done),
        ]
    write_mcap(folder / "episodes.mcap", topics, {}, {})
    return folder / "episodes.mcap"


def test_episodes_come_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    found = McapExpert(str(written(tmp_path)), None).demonstrations()
    assert found.lengths == tuple(LENGTHS)
    expected = torch.cat([100.0 * (k + 1) + torch.arange(float(n)) for k, n in enumerate(LENGTHS)])
    assert torch.equal(found.observation, expected[:, None] * torch.ones(2))
    assert torch.equal(found.after, found.observation + 1.0)
    assert torch.equal(found.action, 10.0 * found.observation[:, :1])
    assert torch.equal(found.transitions(1), torch.stack([expected, 10.0 * expected, expected + 1.0], 1))


def test_the_first_ones_are_taken_and_too_few_are_told(tmp_path: Path) -> None:
    path = str(written(tmp_path))
    assert McapExpert(path, 2).demonstrations().lengths == (3, 5)
    with pytest.raises(ConfigError, match=r"holds 11 trajectories; 12 are asked for"):
        McapExpert(path, 12).demonstrations()
    with pytest.raises(ConfigError, match=r"expert\.episodes is 0; expected at least 1"):
        McapExpert(path, 0)


def test_what_is_no_file_of_episodes_is_told(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"There is no file .*evaluator=demonstrations"):
        McapExpert(str(tmp_path / "none.mcap"), None).demonstrations()
    with pytest.raises(DataError, match=r"3 observations and 3 actions; expected one observation more"):
        McapExpert(str(written(tmp_path, [3], lost=1)), None).demonstrations()
    write_mcap(tmp_path / "log.mcap", [FloatArrays("/u", ("u",), np.zeros(1), np.zeros((1, 1)))], {}, {})
    with pytest.raises(DataError, match=r"none of its topics ends in /observation \(/u\)"):
        McapExpert(str(tmp_path / "log.mcap"), None).demonstrations()


def test_episodes_that_cannot_be_learnt_from_are_told(tmp_path: Path) -> None:
    def episode(number: int, seen: Array) -> list[FloatArrays]:
        done = FloatArrays(f"/episode_{number}/action", ("u",), np.arange(2.0), np.ones((2, 1)))
        labels = tuple("abc"[: seen.shape[1]])
        return [FloatArrays(f"/episode_{number}/observation", labels, np.arange(3.0), seen), done]

    path = tmp_path / "episodes.mcap"
    write_mcap(path, [*episode(1, np.ones((3, 2))), *episode(2, np.ones((3, 3)))], {}, {})
    with pytest.raises(DataError, match=r"/episode_1 sees 2 numbers and does 1; /episode_2 sees 3 numbers and does 1"):
        McapExpert(str(path), None).demonstrations()
    assert McapExpert(str(path), 1).demonstrations().lengths == (2,)
    write_mcap(path, episode(1, np.array([[1.0], [np.nan], [2.0]])), {}, {})
    with pytest.raises(DataError, match=r"/episode_1 of .* holds NaN"):
        McapExpert(str(path), None).demonstrations()


def test_other_widths_are_told() -> None:
    found = Demonstrations.of([(torch.zeros(3, 4), torch.zeros(2, 1))])
    found.require_widths(4, 1, "algorithm=gail")
    with pytest.raises(ConfigError, match=r"expert of algorithm=gail sees 4 numbers and does 1; .* sees 5 .* does 1"):
        found.require_widths(5, 1, "algorithm=gail")


def test_a_target_is_played_and_cut_where_an_episode_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "require_mujoco", lambda environment, _: environment)
    seen = torch.arange(8.0).reshape(2, 4, 1)
    mask = torch.tensor([[True, True, True, True], [True, True, False, False]])
    then = TensorDict({"observation": seen + 1.0}, batch_size=[2, 4])
    played = TensorDict({"observation": seen, "action": -seen, "mask": mask, "next": then}, batch_size=[2, 4])

    class Played:
        def play(self, drive: None, starts: None, count: int) -> TensorDict:
            assert drive is None
            assert starts is None
            return played[:count]

    found = module.TargetExpert(None, lambda _: Played(), 2).demonstrations()  # pyright: ignore[reportArgumentType]
    assert found.lengths == (4, 2)
    assert found.observation.flatten().tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    assert found.after.flatten().tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert torch.equal(found.action, -found.observation)
