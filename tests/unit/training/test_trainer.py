"""The shared loop: a run that was interrupted equals one that was not."""

import math
import resource
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import torch
from point_mass import LIMIT, PointCollector, ppo
from pretended_experience import PretendedExperience

from dr_lab.collectors.first_episodes import first_episodes
from dr_lab.distribution_learners.lsdr import LSDR
from dr_lab.errors import DrLabError
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.parameter import Parameter
from dr_lab.randomizers.discrete import DiscreteRandomizer
from dr_lab.randomizers.uniform import UniformRandomizer
from dr_lab.training.checkpoint import load, save
from dr_lab.training.episode_log import EpisodeLog, Finished
from dr_lab.training.trainer import Trainer
from dr_lab.trajectory import Array

GAIN = ContextSpace((Parameter("gain", "1", 1.0, 0.0, 2.0),))
FRAMES = 480


def below_one(z: Array) -> Array:
    return np.where(z[:, 0] < 1.0, 1.0, 0.0)


def trainer(folder: Path, every: int = 1, seed: int = 0, between: int = 1) -> Trainer:
    algorithm = ppo(seed)
    learner = LSDR(
        DiscreteRandomizer(GAIN, {}, bins=8),
        seed=seed,
        prior=lambda space: UniformRandomizer(space, {}),
        source="prior",
        every=between,
        contexts=6,
        steps=3,
        learning_rate=0.01,
        alpha=0.2,
        return_rate=0.1,
        divergence_samples=10,
    )
    collector = PointCollector(algorithm.policies["policy"], seed=seed)
    experience = PretendedExperience(below_one, collector)
    return Trainer(experience, algorithm, learner, folder / "checkpoint.pt", every)


def ignore(figures: object, finished: Finished) -> None:
    del figures, finished


def without_time(history: list[dict[str, float]]) -> list[dict[str, float]]:
    return [{k: v for k, v in row.items() if k != "seconds" and not math.isnan(v)} for row in history]


def test_a_resumed_run_equals_an_uninterrupted_one(tmp_path: Path) -> None:
    whole = trainer(tmp_path / "whole")
    whole.run(4 * FRAMES, ignore)

    class Killed(Exception):  # noqa: N818 (no error)
        pass

    def kill(figures: Mapping[str, float], finished: Finished) -> None:
        del finished
        if figures["iteration"] == 3:
            raise Killed

    interrupted = trainer(tmp_path / "cut", every=2 * FRAMES)
    with pytest.raises(Killed):
        interrupted.run(4 * FRAMES, kill)
    resumed = trainer(tmp_path / "cut", seed=5)
    resumed.resume(tmp_path / "cut" / "checkpoint.pt")
    assert resumed.frames == 2 * FRAMES
    resumed.run(4 * FRAMES, ignore)
    assert without_time(resumed.history) == without_time(whole.history)
    first, second = (load(tmp_path / name / "checkpoint.pt") for name in ("whole", "cut"))
    for part in ("actor", "critic"):
        for a, b in zip(first["algorithm"][part].values(), second["algorithm"][part].values(), strict=True):
            assert torch.equal(a, b)
    assert torch.equal(first["learner"]["randomizer"]["logits"], second["learner"]["randomizer"]["logits"])


def test_a_run_that_is_resumed_at_its_end_has_a_checkpoint_of_its_own(tmp_path: Path) -> None:
    trainer(tmp_path / "first").run(FRAMES, ignore)
    resumed = trainer(tmp_path / "second")
    resumed.resume(tmp_path / "first" / "checkpoint.pt")
    resumed.run(FRAMES, ignore)
    assert load(tmp_path / "second" / "checkpoint.pt")["history"] == resumed.history


def test_a_policy_that_is_not_finite_stops_the_run_and_is_not_saved(tmp_path: Path) -> None:
    run = trainer(tmp_path)
    run.run(FRAMES, ignore)
    saved = load(tmp_path / "checkpoint.pt")
    cast(Any, run)._algorithm.actor_rate = math.nan
    with pytest.raises(DrLabError, match=r"After 960 control steps algorithm\.actor\..* is no longer finite"):
        run.run(3 * FRAMES, ignore)
    assert load(tmp_path / "checkpoint.pt")["history"] == saved["history"]


def test_a_full_disk_is_told_and_leaves_the_last_checkpoint(tmp_path: Path) -> None:
    path = tmp_path / "checkpoint.pt"
    save(path, {"kept": 1})
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, before[1]))
    try:
        with pytest.raises(DrLabError, match=r"Cannot write the checkpoint .*checkpoint\.pt: .* room"):
            save(path, {"large": torch.zeros(100_000)})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert load(path) == {"kept": 1}
    assert [each.name for each in tmp_path.iterdir()] == ["checkpoint.pt"]


def test_checkpoints_are_counted_in_control_steps(tmp_path: Path) -> None:
    run, due = trainer(tmp_path, every=FRAMES + FRAMES // 2), list[bool]()
    run.run(5 * FRAMES, lambda *_: due.append(run.due))
    # 480, 960, 1440, 1920, 2400 against multiples of 720
    assert due == [False, True, True, False, True]


def test_figures_of_all_parts_are_recorded(tmp_path: Path) -> None:
    seen: list[tuple[dict[str, float], Finished]] = []
    run = trainer(tmp_path)
    run.run(2 * FRAMES, lambda figures, finished: seen.append((dict(figures), finished)))
    figures, finished = seen[-1]
    assert {"iteration", "frames", "episode_return", "kl", "entropy", "divergence"} <= set(figures)
    assert figures["frames"] == 2 * FRAMES == run.frames
    assert figures["rollout_frames"] == 2 * 6  # of the learner's own episodes, of one step each
    assert figures["episodes"] == len(finished.returns) == 32
    assert (finished.lengths == LIMIT).all()


def test_episodes_are_followed_from_batch_to_batch() -> None:
    batch = next(PointCollector(ppo().policies["policy"], steps=40))
    whole = EpisodeLog().take(batch)
    log, parts = EpisodeLog(), []
    for piece in batch.split(10, dim=1):
        parts.append(log.take(piece))
    np.testing.assert_allclose(np.concatenate([p.returns for p in parts]), whole.returns)
    np.testing.assert_array_equal(np.concatenate([p.lengths for p in parts]), whole.lengths)
    np.testing.assert_array_equal(np.concatenate([p.context for p in parts]), whole.context)
    first = batch["next", "reward"][:, :LIMIT].sum(1)[:, 0]
    torch.testing.assert_close(torch.from_numpy(whole.returns[: len(first)]).float(), first)


def test_what_staggering_cuts_is_no_episode() -> None:
    batch = next(PointCollector(ppo().policies["policy"], n=3, steps=LIMIT + 4))
    batch["next", "done"][0, 3] = batch["next", "truncated"][0, 3] = True
    batch["next", "done"][1, 5] = batch["next", "terminated"][1, 5] = True
    finished = EpisodeLog(LIMIT).take(batch)
    # The first slot's four steps are left out, and the eleven after them, which the same limit cuts.
    assert finished.lengths.tolist() == [6, LIMIT]
    assert finished.returns[1] == pytest.approx(float(batch["next", "reward"][2, :LIMIT].sum()))


def test_of_slots_that_play_whole_episodes_the_first_ones_are_counted() -> None:
    """Those that follow would be counted where they are short, and cut where they are long."""
    batch = next(PointCollector(ppo().policies["policy"], n=2, steps=LIMIT))
    batch["next", "reward"][:] = 1.0
    for t in (1, 4, 6):
        batch["next", "done"][1, t] = batch["next", "terminated"][1, t] = True
    assert EpisodeLog(LIMIT).take(batch).returns.tolist() == [2.0, 3.0, 2.0, LIMIT]  # of batches that go on
    batch["first"] = first_episodes(batch)
    assert EpisodeLog(LIMIT).take(batch).returns.tolist() == [2.0, LIMIT]


def test_infeasible_episodes_are_counted_and_averaged_over_by_nothing() -> None:
    batch = next(PointCollector(ppo().policies["policy"], n=3, steps=LIMIT))
    batch["next", "infeasible"][0] = batch["next", "done"][0]
    finished = EpisodeLog().take(batch)
    assert finished.infeasible.tolist() == [True, False, False]
    figures = finished.figures()
    assert (figures["episodes"], figures["infeasible_episodes"], figures["episode_length"]) == (3.0, 1.0, LIMIT)
    assert figures["episode_return"] == pytest.approx(float(finished.returns[1:].mean()))
    figures = EpisodeLog().take(batch[:1]).figures()
    assert (figures["episodes"], figures["infeasible_episodes"]) == (1.0, 1.0)
    assert math.isnan(figures["episode_return"])


def test_the_distribution_is_learnt_after_so_many_control_steps(tmp_path: Path) -> None:
    run = trainer(tmp_path, between=FRAMES + 1)
    run.run(4 * FRAMES, ignore)
    learnt = ["entropy" in row for row in run.history]
    assert learnt == [False, True, True, True]  # 481 is passed at 960, 962 at 1440, 1443 at 1920


@pytest.mark.parametrize(("between", "first"), [(FRAMES, 3 * FRAMES), (FRAMES // 4, 9 * FRAMES // 4)])
def test_nothing_is_learnt_of_a_distribution_before_its_first_control_step(
    between: int, first: int, tmp_path: Path
) -> None:
    """Also where a batch is longer than a turn."""
    run = trainer(tmp_path, between=between)
    cast(Any, run)._learner.first = first
    run.run(4 * FRAMES, ignore)
    assert ["entropy" in row for row in run.history] == [False, False, True, True]
