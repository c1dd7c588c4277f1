"""A short training run from the command line, stopped and continued."""

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest
import torch

from dr_lab.cli.arguments import compose_arguments
from dr_lab.cli.compose import compose_from
from dr_lab.cli.folders import shipped
from dr_lab.cli.job import Job, run_job
from dr_lab.errors import ConfigError, DataError
from dr_lab.reports.json_file import typed
from dr_lab.reports.train import TrainReport
from dr_lab.training.checkpoint import load
from dr_lab.training.history import final_episodes, final_return, metrics_csv
from dr_lab.workflows.train import train

OVERRIDES = [
    "env=cartpole",
    "env.task.time_limit=20",
    "algorithm.batch_frames=160",
    "algorithm.minibatch=40",
    "algorithm.epochs=2",
    "distribution_learner=none",
    "collector=lean",
    "episodes=8",
    "rollout_episodes=4",
    "checkpoint_every=1",
    "threads=1",
]


def run(folder: Path, *more: str) -> TrainReport:
    folder.mkdir()
    return train(**compose_arguments("train", [*OVERRIDES, *more], (shipped(),)), run_dir=folder)


def job(folder: Path, *overrides: str) -> None:
    folders = (shipped(),)
    run_job(Job("train", overrides, "run", folder, folders), compose_from(folders, "train", overrides))


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as file:
        return [{k: v for k, v in row.items() if k != "seconds"} for row in csv.DictReader(file)]


def test_a_continued_run_leaves_what_an_uninterrupted_one_leaves(tmp_path: Path) -> None:
    report = run(tmp_path / "whole", "frames=640", "algorithm.anneal_frames=640")
    run(tmp_path / "first", "frames=320", "algorithm.anneal_frames=640")
    run(tmp_path / "second", "frames=640", "algorithm.anneal_frames=640", f"resume={tmp_path / 'first'}")
    rows = [rows_of(tmp_path / name / "metrics.csv") for name in ("whole", "second")]
    assert rows[0] == rows[1]
    assert [row["frames"] for row in rows[0]] == ["160", "320", "480", "640"]
    drawn, again = (rows_of(tmp_path / name / "contexts.csv") for name in ("whole", "second"))
    assert drawn == again
    assert len(drawn) >= 8 * 4  # 8 slots play 4 whole episodes each
    path = tmp_path / "whole" / "report.json"
    assert report == typed(TrainReport, json.loads(path.read_text(encoding="utf-8")), path)
    assert report.final_return is not None
    assert report.final_episodes == 8  # one of each slot, in the last iteration
    assert report.choice is not None
    chosen = [each.mean_return for each in report.choice.snapshots if each.frames == report.choice.chosen]
    assert [report.deployed_return] == chosen
    assert [episode.ended for episode in report.episodes] == ["truncated"] * 3
    for name in ("report.md", "report.html", "review.rrd", "episodes.mcap"):
        assert (tmp_path / "whole" / name).stat().st_size > 0
    assert load(tmp_path / "second" / "checkpoint.pt")["history"][-1]["frames"] == 640


@pytest.mark.slow
def test_a_run_that_is_resumed_at_its_end_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(tmp_path / "first", "frames=320")
    assert "nothing is left" not in capsys.readouterr().out
    run(tmp_path / "second", "frames=160", f"resume={tmp_path / 'first'}")
    assert "has played 320 control steps, and frames is 160: nothing is left to be trained" in capsys.readouterr().out


@pytest.mark.slow
def test_a_report_calls_the_algorithm_by_its_name(tmp_path: Path) -> None:
    assert run(tmp_path / "one", "frames=160").algorithm == "PPO"
    assert run(tmp_path / "other", "algorithm=epopt", "frames=160").algorithm == "EPOpt"


@pytest.mark.slow
def test_a_run_keeps_its_last_policies_and_deploys_the_best_of_them(tmp_path: Path) -> None:
    report = run(tmp_path / "run", "frames=1920")
    kept = load(tmp_path / "run" / "checkpoint.pt")
    taken = kept["policies"]["taken"]
    assert [each["frames"] for each in taken] == [160 * k for k in range(3, 13)]  # the last ten of twelve
    choice = report.choice
    assert choice is not None
    assert [each.frames for each in choice.snapshots] == [each["frames"] for each in taken]
    best = max(choice.snapshots, key=lambda each: each.mean_return or -math.inf)
    assert choice.chosen == best.frames
    assert choice.choice_frames == 10 * 16 * 20  # no episode of the cart-pole ends before its 20 steps
    deployed = load(tmp_path / "run" / "policy.pt")
    assert deployed["frames"] == choice.chosen
    for name, value in kept["algorithm"]["actor"].items():  # the last is what the run goes on from
        assert torch.equal(value, taken[-1]["policies"]["policy"][name])
    assert "by which it was chosen, 3200 control steps in all," in (tmp_path / "run" / "report.md").read_text(
        encoding="utf-8"
    )


def test_a_run_that_cannot_be_continued_is_told(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"Cannot read the checkpoint .*nowhere"):
        run(tmp_path / "run", "frames=160", f"resume={tmp_path / 'nowhere'}")


@pytest.mark.slow
def test_only_a_run_with_the_same_settings_is_gone_on_with(tmp_path: Path) -> None:
    first = tmp_path / "first"
    job(first, *OVERRIDES, "frames=160")
    going_on = [f"resume={first}", "frames=320", "threads=2", "recorder.episodes=1", "checkpoint_every=500"]
    for setting, told in (
        ("algorithm.gamma=0.5", r"algorithm\.gamma is 0\.5, there 0\.99\. "),
        ("env.task.frame_skip=1", r"env\.task\.frame_skip is 1, there \d+\. "),
        ("~algorithm.surrogate.clip", r"algorithm\.surrogate\.clip is absent, there 0\.2\. "),
    ):
        with pytest.raises(ConfigError, match=told):
            job(tmp_path / "other", *OVERRIDES, *going_on, setting)
    with pytest.raises(
        ConfigError, match=r"and \d+ more\. Its overrides were: env=cartpole env\.task.*config-name config"
    ):
        job(tmp_path / "default", f"resume={first}")
    assert not (tmp_path / "default").exists()
    job(tmp_path / "second", *OVERRIDES, *going_on)
    assert [row["frames"] for row in rows_of(tmp_path / "second" / "metrics.csv")] == ["160", "320"]


def test_a_folder_without_settings_is_told(tmp_path: Path) -> None:
    with pytest.raises(
        ConfigError, match=r"There is no folder .*/nowhere\. Give resume=FOLDER of a run of dr-lab train"
    ):
        job(tmp_path / "run", *OVERRIDES, f"resume={tmp_path / 'nowhere'}")
    with pytest.raises(ConfigError, match=r"holds no config\.yaml\. Give resume=FOLDER of a run of dr-lab train"):
        job(tmp_path / "run", *OVERRIDES, f"resume={tmp_path}")


def test_a_batch_smaller_than_the_slots_is_told(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="less than one control step"):
        run(tmp_path / "run", "algorithm.batch_frames=7")
    with pytest.raises(ConfigError, match="frames is 0; expected"):
        run(tmp_path / "none", "frames=0")


@pytest.mark.parametrize(
    ("name", "algorithm"),
    [
        ("TD3", ["algorithm=td3"]),
        ("GAIL", ["algorithm=gail", "algorithm@algorithm.learner=ddpg", "algorithm.expert.path=nowhere"]),
    ],
)
def test_a_run_that_ends_before_its_policy_learns_is_refused(tmp_path: Path, name: str, algorithm: list[str]) -> None:
    given = [each for each in OVERRIDES if not each.startswith("algorithm.")]
    arguments = compose_arguments("train", [*given, *algorithm, "frames=9999"], (shipped(),))
    with pytest.raises(ConfigError, match=f"frames is 9999, but {name} learns from control step 10000 on"):
        train(**arguments, run_dir=tmp_path)


def test_infeasible_episodes_are_told_and_no_part_of_the_final_return(tmp_path: Path) -> None:
    sizes = ["env=hopper", "env/context=hopper/torso_size", "env.task.time_limit=20", "randomizer=uniform"]
    report = run(tmp_path / "run", *sizes, "env.infeasible_return=-1e6", "frames=160", "recorder.episodes=1")
    (row,) = rows_of(tmp_path / "run" / "metrics.csv")
    assert report.infeasible_episodes == int(row["infeasible_episodes"]) > 0
    assert abs(float(row["episode_return"])) < 100.0
    said = f"which no mean return counts: {report.infeasible_episodes} of {int(row['episodes'])} ("
    assert said in (tmp_path / "run" / "report.md").read_text(encoding="utf-8")


def test_the_final_return_is_that_of_the_last_feasible_episodes() -> None:
    first = {"episodes": 9.0, "episode_return": 50.0, "infeasible_episodes": 0.0}
    rows = [first] * 18 + [first | {"episode_return": 1.0, "infeasible_episodes": 8.0}] + [first]
    assert final_return(rows, 0.1) == pytest.approx((1.0 + 9 * 50.0) / 10)
    assert final_episodes(rows, 0.1) == 10
    none = {"episodes": 3.0, "episode_return": math.nan, "infeasible_episodes": 3.0}
    assert final_return([none], 0.1) is None


def test_metrics_leave_out_what_is_unknown() -> None:
    text = metrics_csv([{"a": 1.0, "b": np.nan}, {"a": 2.5, "c": 1e-7}])
    assert text == "a,b,c\n1,,\n2.5,,1e-07\n"
