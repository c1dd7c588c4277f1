"""A short training run from the command line, evaluated in all ways."""

import csv
import functools
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import torch
from test_train import OVERRIDES

from dr_lab.__main__ import main
from dr_lab.cli.arguments import compose_arguments
from dr_lab.cli.compose import compose_from
from dr_lab.cli.folders import shipped
from dr_lab.cli.job import Job, run_job
from dr_lab.errors import ConfigError, DataError
from dr_lab.evaluators.trained_run import TrainedRun, subject_of
from dr_lab.randomizers.fixed import FixedRandomizer
from dr_lab.reports.evaluate import EvaluateReport
from dr_lab.reports.json_file import typed
from dr_lab.training.checkpoint import load, save
from dr_lab.workflows.evaluate import evaluate

TRAIN = [*OVERRIDES, "env=furuta", "frames=320", "randomizer=fixed"]

# Equal parameters may lie elsewhere in memory, which changes the last digit of a product.
close = functools.partial(torch.allclose, rtol=1e-6, atol=1e-6)


def job(verb: str, folder: Path, overrides: list[str]) -> None:
    run_job(Job(verb, tuple(overrides), "run", folder, (shipped(),)), compose_from((shipped(),), verb, overrides))


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "train"
    job("train", folder, TRAIN)
    return folder


@pytest.mark.slow
def test_what_was_trained_on_is_recorded_as_it_was_composed(run: Path) -> None:
    text = (run / "config.yaml").read_text(encoding="utf-8")
    assert "mjcf: ${conf:model/furuta.xml}" in text
    assert "env: ${env}" in text


def test_a_context_that_is_fixed_has_no_spread(run: Path) -> None:
    report = json.loads((run / "report.json").read_text(encoding="utf-8"))
    arm = report["context"]["arm.mass"]
    assert (arm["mean"], arm["std"]) == (0.095, 0.0)


def evaluated(run: Path, folder: Path, *overrides: str) -> EvaluateReport:
    folder.mkdir()
    arguments = compose_arguments("evaluate", [f"run={run}", *overrides], (shipped(),))
    compose = functools.partial(compose_arguments, folders=(shipped(),))
    return evaluate(**arguments, compose=compose, run_dir=folder)


def test_a_grid_is_played_written_and_drawn(run: Path, tmp_path: Path) -> None:
    cells = "evaluator.axes={arm.mass: [0.05, 0.15, 3]}"
    report = evaluated(run, tmp_path / "grid", "evaluator=grid", cells, "evaluator.episodes=2", "evaluator.parallel=4")
    written = tmp_path / "grid" / "report.json"
    assert report == typed(EvaluateReport, json.loads(written.read_text(encoding="utf-8")), written)
    assert report.trained == str(run)
    with (tmp_path / "grid" / "returns.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["return"]) for row in rows] == pytest.approx([row["return"] for row in report.rows])
    assert len(rows) == 3
    assert report.units == {"arm.mass": "kg"}
    page = (tmp_path / "grid" / "report.md").read_text(encoding="utf-8")
    assert "| arm.mass [kg] | return | std | diverged |" in page
    assert "2 episodes in each of 3 contexts" in page
    for name in ("report.html", "review.rrd", "episodes.mcap"):
        assert (tmp_path / "grid" / name).stat().st_size > 0
    assert len(report.episodes) == 3


def test_a_policy_is_trained_on_in_a_context(run: Path, tmp_path: Path) -> None:
    few = ["evaluator.contexts=1", "evaluator.rounds=1", "evaluator.frames=160", "evaluator.episodes=2"]
    report = evaluated(run, tmp_path / "tuned", "evaluator=fine_tune", *few)
    assert None not in (report.figures["jump_start"], report.figures["asymptote"])
    assert not list((tmp_path / "tuned").glob("*.pt"))
    assert (report.units["arm.mass"], report.units["arm.damping"]) == ("kg", "N·m·s/rad")


def test_training_on_begins_with_episodes_that_have_no_past(run: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(run, tmp_path / "run")
    state = load(folder / "checkpoint.pt")
    state["algorithm"]["reward_scale"]["sum"] = torch.ones(8)  # of episodes that were cut off by the run's end
    save(folder / "checkpoint.pt", state)
    subject = subject_of(folder, functools.partial(compose_arguments, folders=(shipped(),)), threads=1)
    trainer, _ = subject.again(FixedRandomizer(subject.setting.space, {}), 0)
    begun = trainer.state_dict()["algorithm"]["reward_scale"]
    assert not begun["sum"].any()
    assert begun["count"] == state["algorithm"]["reward_scale"]["count"]


def test_training_on_explores_by_the_seed_it_is_given(run: Path) -> None:
    subject = subject_of(run, functools.partial(compose_arguments, folders=(shipped(),)), threads=1)
    contexts = FixedRandomizer(subject.setting.space, {})
    noise = [subject.again(contexts, seed)[0].state_dict()["algorithm"]["actor"]["_extra_state"] for seed in (0, 0, 1)]
    assert torch.equal(noise[0], noise[1])
    assert not torch.equal(noise[0], noise[2])


def test_every_policy_that_was_kept_is_evaluated_with_and_without_exploration(run: Path, tmp_path: Path) -> None:
    report = evaluated(run, tmp_path / "kept", "evaluator=snapshots", "evaluator.episodes=3")
    assert [row["frames"] for row in report.rows] == [160, 320]
    figures = report.figures
    for name in ("deterministic", "stochastic"):
        assert figures[f"{name}.last"] == report.rows[-1][name]
        assert figures[f"{name}.iqm"] == pytest.approx(np.mean([float(row[name] or "nan") for row in report.rows]))
    assert figures["deterministic.last"] != figures["stochastic.last"]


def test_the_chosen_policy_is_deployed_and_trained_on_and_the_last_is_kept(run: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(run, tmp_path / "run")
    first, last = load(folder / "checkpoint.pt")["policies"]["taken"]
    save(folder / "policy.pt", first)
    compose = functools.partial(compose_arguments, folders=(shipped(),))
    subject = subject_of(folder, compose, threads=1)
    width = subject.slots(1, 0).observation.shape[1]
    observation = torch.randn(5, width, generator=torch.Generator().manual_seed(0))
    acts = [each.deployed(observation) for each in subject.snapshots]
    assert close(subject.policy(observation), acts[0])
    assert not close(acts[0], acts[1])
    _, trained_on = subject.again(FixedRandomizer(subject.setting.space, {}), 0)
    assert close(trained_on(observation), acts[0])
    (folder / "policy.pt").unlink()  # as of a run that has not ended
    assert close(subject_of(folder, compose, threads=1).policy(observation), acts[1])
    assert last["frames"] == 320


def test_training_on_begins_with_its_own_rates_and_new_episodes(run: Path) -> None:
    subject = subject_of(run, functools.partial(compose_arguments, folders=(shipped(),)), threads=1)
    state = subject.again(FixedRandomizer(subject.setting.space, {}), 0)[0].state_dict()["algorithm"]
    assert load(run / "checkpoint.pt")["algorithm"]["frames"] == 320
    assert state["frames"] == 0
    assert state["further"]
    assert state["reward_scale"]["sum"].abs().max() == 0.0


def test_training_a_learner_and_an_evaluator_start_their_episodes_apart(run: Path) -> None:
    state = load(run / "checkpoint.pt")
    subject = subject_of(run, functools.partial(compose_arguments, folders=(shipped(),)), threads=1)
    trained_on = subject.setting.make(None, 4, 0, threads=1).episodes
    starts = [episodes.state[0] for episodes in (trained_on, subject.slots(4, 0))]
    assert not np.isclose(starts[0], starts[1]).all(1).any()
    slots = [state["experience"][part]["streams"] for part in ("collector", "episodes")]
    seeds = [{str(each["state"]["inc"]) for each in streams} for streams in slots]
    assert seeds[0].isdisjoint(seeds[1])


def test_contexts_that_are_all_the_same_are_not_trained_on_in_one_by_one(tmp_path: Path) -> None:
    job("train", tmp_path / "plain", [*OVERRIDES, "env=half_cheetah", "frames=160"])
    with pytest.raises(ConfigError, match=r"all the same: half_cheetah has no parameters. Give evaluator\.contexts=1"):
        evaluated(tmp_path / "plain", tmp_path / "tuned", "evaluator=fine_tune")


def test_the_command_line_evaluates_what_it_has_trained(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["evaluate", f"run={run}", "evaluator=returns", "evaluator.contexts=3", "hydra.run.dir=run"]) == 0
    assert "uniform" in (tmp_path / "run" / "report.md").read_text(encoding="utf-8")


def test_a_run_is_evaluated_whatever_else_its_configuration_holds(run: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(run, tmp_path / "run")
    with (folder / "config.yaml").open("a", encoding="utf-8") as file:
        file.write("gone_since: 1\n")
    subject = subject_of(folder, functools.partial(compose_arguments, folders=(shipped(),)), threads=1)
    assert subject.setting.name == "furuta"


def test_a_run_is_evaluated_whatever_device_it_learnt_on(run: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(run, tmp_path / "run")
    config = (folder / "config.yaml").read_text(encoding="utf-8")
    assert "device: cpu" in config
    (folder / "config.yaml").write_text(config.replace("device: cpu", "device: cuda:99"), encoding="utf-8")
    subject = subject_of(folder, functools.partial(compose_arguments, folders=(shipped(),)), threads=1)
    assert subject.setting.name == "furuta"


def test_a_checkpoint_of_another_run_is_told(run: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(run, tmp_path / "run")
    state = load(folder / "checkpoint.pt")
    del state["algorithm"]["actor"]["log_std"]
    save(folder / "checkpoint.pt", state)
    compose = functools.partial(compose_arguments, folders=(shipped(),))
    with pytest.raises(DataError, match=r"checkpoint\.pt does not fit .*config\.yaml.*log_std"):
        subject_of(folder, compose, threads=1)


def folder_of(run: Path | str, runs: Path) -> Path:
    return TrainedRun(str(run), str(runs), threads=1).folder()


def test_a_run_is_known_by_its_whole_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "outputs" / "first"
    folder.mkdir(parents=True)
    (folder / "checkpoint.pt").touch()
    monkeypatch.chdir(tmp_path)
    assert folder_of("latest", Path("outputs")) == folder_of("outputs/first", Path("outputs")) == folder.resolve()


def test_a_run_without_a_checkpoint_is_told(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"holds no checkpoint\.pt\. Give run=FOLDER"):
        folder_of(tmp_path, tmp_path)
    (tmp_path / "config.yaml").write_text("# dr-lab compare model=furuta\nseed: 0\n")
    with pytest.raises(DataError, match=r"holds no checkpoint\.pt; it is that of a run of dr-lab compare\. Give run="):
        folder_of(tmp_path, tmp_path)
    (tmp_path / "config.yaml").write_text("")
    with pytest.raises(DataError, match=r"holds no checkpoint\.pt\. Give run=FOLDER"):
        folder_of(tmp_path, tmp_path)
    with pytest.raises(DataError, match=r"There is no folder .*/nowhere\. Give run=FOLDER of a training run"):
        folder_of(tmp_path / "nowhere", tmp_path)
    with pytest.raises(DataError, match=r"There is no training run below"):
        folder_of("latest", tmp_path)
