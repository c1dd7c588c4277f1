"""Teachers of earlier runs come with the policies that these chose, in the contexts that these were trained in."""

from pathlib import Path

import numpy as np
import pytest
import torch
from point_mass import INTERFACE, PointCollector, ppo_arguments
from pretended_experience import PretendedExperience
from written_runs import train_report, write_run

from dr_lab.algorithms.ppo.ppo import PPO
from dr_lab.errors import ConfigError, DataError
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.parameter import Parameter
from dr_lab.training.checkpoint import save
from dr_lab.training.finished_teachers import FinishedTeachers
from dr_lab.training.policy_snapshots import PolicySnapshots


class Gains(PretendedExperience):
    """Its context is one gain."""

    @property
    def space(self) -> ContextSpace:
        return ContextSpace((Parameter("gain", "1", 1.0, 0.5, 1.5),))


def learner(interface: object, seed: int) -> PPO:
    del interface
    return PPO(**ppo_arguments(seed=seed))


def teachers(*runs: Path) -> FinishedTeachers:
    return FinishedTeachers(INTERFACE, 0, learner, [str(run) for run in runs], 4)


def gains() -> Gains:
    return Gains(lambda z: np.zeros(len(z)))


def run(folder: Path, seed: int, gain: float, name: str = "gain") -> PPO:
    """A run that chose another policy than its last; gives PPO with that one."""
    entry = {"unit": "1", "mean": gain, "std": 0.0}
    write_run(folder, train_report(1.0, {name: entry}))
    chosen, last = learner(None, seed), learner(None, seed + 10)
    chosen.update(next(PointCollector(chosen.policies["policy"])))
    save(folder / "checkpoint.pt", {"algorithm": last.state_dict()})
    snapshots = PolicySnapshots(chosen, 1)
    snapshots.take(480)
    save(folder / "policy.pt", snapshots.taken[0])
    return chosen


def test_they_do_what_was_chosen_in_the_mean_context_of_their_run(tmp_path: Path) -> None:
    runs = [tmp_path / "a", tmp_path / "b"]
    chosen = [run(folder, seed, gain) for seed, (folder, gain) in enumerate(zip(runs, (0.6, 1.4), strict=True))]
    found = teachers(*runs)
    assert found.slot_contexts(gains()).tolist() == [[0.6], [0.6], [1.4], [1.4]]
    rows = torch.linspace(-1.0, 1.0, 6)[:, None]
    for k, one in enumerate(chosen):
        torch.testing.assert_close(found.members[k].actor.mean(rows), one.actor.mean(rows))
        expected = one.actor.mean(rows[:2])
        torch.testing.assert_close(found.acting.mean(rows[:2].repeat(2, 1))[2 * k : 2 * k + 2], expected)


def test_one_that_goes_on_needs_the_runs_no_more(tmp_path: Path) -> None:
    run(tmp_path / "a", 0, 0.6)
    first = teachers(tmp_path / "a")
    first.slot_contexts(gains())
    second = teachers(tmp_path / "gone")
    second.load_state_dict(first.state_dict())
    assert second.slot_contexts(gains()).tolist() == [[0.6]] * 4
    rows = torch.linspace(-1.0, 1.0, 4)[:, None]
    torch.testing.assert_close(second.acting.mean(rows), first.acting.mean(rows))


def test_what_cannot_teach_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"algorithm.teachers.runs is empty"):
        teachers()
    with pytest.raises(DataError, match=r"There is no folder .*Give folders of finished runs"):
        teachers(tmp_path / "gone").slot_contexts(gains())
    run(tmp_path / "other", 0, 0.6, "mass")
    with pytest.raises(DataError, match="trained in contexts of mass; expected gain"):
        teachers(tmp_path / "other").slot_contexts(gains())
    (tmp_path / "other" / "report.json").write_text("{", "utf-8")
    with pytest.raises(DataError, match=r"has a report\.json that cannot be read: Expecting property name"):
        teachers(tmp_path / "other").slot_contexts(gains())
    (tmp_path / "other" / "report.json").unlink()
    with pytest.raises(DataError, match=r"has no report.json"):
        teachers(tmp_path / "other").slot_contexts(gains())
    save(tmp_path / "other" / "checkpoint.pt", {"algorithm": {}})
    with pytest.raises(DataError, match="a run of another algorithm or has other networks"):
        teachers(tmp_path / "other").slot_contexts(gains())
