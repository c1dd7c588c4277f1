"""Episodes of a shipped machine, kept with its model; its file has an attribute that MuJoCo calls old."""

from pathlib import Path
from typing import NoReturn

import mujoco
import numpy as np
import torch
from mcap.reader import make_reader
from settings import setting
from torch import Tensor

from dr_lab.evaluators.evaluator import Subject
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.training.episodes import FILE, described, keep_episodes, play_episodes


def still(observation: Tensor) -> Tensor:
    return torch.zeros(len(observation), 6)


def test_the_file_of_episodes_carries_the_model_that_was_played(tmp_path: Path) -> None:
    found = setting("half_cheetah", "env.task.time_limit=5")
    episodes = play_episodes(found, still, None, 2, seed=0, threads=1)
    keep_episodes(tmp_path, found, episodes)
    with (tmp_path / FILE).open("rb") as file:
        (model,) = make_reader(file).iter_attachments()
    assert mujoco.MjModel.from_xml_string(model.data.decode()).nq == found.model.nominal().nq
    told = described(episodes)
    assert [(each.name, each.ended, each.context) for each in told] == [
        ("episode_1", "truncated", {}),
        ("episode_2", "truncated", {}),
    ]
    assert (episodes[0].qpos[0] != episodes[1].qpos[0]).any()


def test_neither_shown_nor_evaluated_episodes_begin_as_training_did() -> None:
    found = setting("half_cheetah", "env.task.time_limit=5")
    trained = found.make(None, 2, 0, 1).episodes.state[0]
    evaluated = Subject("run", found, still, again, threads=1).slots(2, seed=0).state[0]
    shown = np.array([episode.qpos[0] for episode in play_episodes(found, still, None, 2, seed=0, threads=1)])
    starts = np.concatenate([trained, evaluated, shown])
    assert len(np.unique(starts, axis=0)) == 6


def again(source: ContextSource, seed: int) -> NoReturn:
    raise AssertionError("no policy is trained here")


def test_no_episodes_leave_no_file(tmp_path: Path) -> None:
    keep_episodes(tmp_path, setting("half_cheetah", "env.task.time_limit=5"), [])
    assert not (tmp_path / FILE).exists()
