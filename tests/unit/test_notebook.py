"""In a notebook the verbs do what they do on the command line."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import dr_lab
from dr_lab import Comparison, evaluate, record, train
from dr_lab.__main__ import main
from dr_lab.errors import ConfigError, DataError
from dr_lab.reports.evaluate import EvaluateReport
from dr_lab.reports.gap import GapReport
from dr_lab.reports.plain import from_plain, to_plain
from dr_lab.reports.train import TrainReport

SMALL = ("measurements.fit=['log_1[0:2]']", "measurements.held_out=[]", "windows.seconds=0.9", "threads=1")
SHORT = (
    "env=furuta_balance",
    "frames=512",
    "episodes=4",
    "algorithm.batch_frames=256",
    "choice.episodes=1",
    "threads=1",
)
LIGHT = "import sys, dr_lab; print(*({'torch', 'mujoco', 'numpy', 'hydra'} & {*sys.modules}))"


@pytest.mark.slow
def test_a_verb_is_a_method_that_does_what_the_command_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    report = Comparison.load("furuta", "furuta", *SMALL).compare()
    (folder,) = Path("outputs/compare/furuta").iterdir()
    typed = ["compare", "model=furuta", "measurements=furuta", *SMALL, "hydra.run.dir=typed"]
    assert main(typed) == 0
    written, of_command = (json.loads((place / "report.json").read_text()) for place in (folder, Path("typed")))
    assert to_plain(report) == written
    assert from_plain(GapReport, written) == report
    assert report.run == str(folder)
    again = ["compare", f"--config-dir={folder}", "--config-name=config", "hydra.run.dir=again"]
    assert main(again) == 0
    assert json.loads(Path("again/report.json").read_text())["ladder"] == written["ladder"]
    assert written | {"run": of_command["run"]} == of_command


@pytest.mark.slow
def test_a_verb_takes_the_settings_that_the_comparison_has(tmp_path: Path) -> None:
    loaded = Comparison.load("furuta", "furuta", *SMALL)
    settings = replace(loaded.settings, windows=replace(loaded.settings.windows, seconds=1.5))
    longer = replace(loaded, settings=settings).add("coulomb_friction", tmp_path, joint="arm")
    assert longer.windows.fit == 5
    assert not (tmp_path / "config.yaml").exists()  # which would be that of other settings
    assert longer.ladder[-1].effects == ("coulomb_friction@arm",)


@pytest.mark.parametrize(
    ("model", "given", "error", "told"),
    [
        ("furuta", "windows.length=long", ConfigError, r"windows\.length is 'long'"),
        ("furuta", "windows.lenth=1", ConfigError, r"Did you mean 'windows\.length'"),
        ("furuta", "-m", ConfigError, "expected key=value"),
        ("furuta", ["seed=1"], ConfigError, r"\['seed=1'\] is no override; expected texts"),
        ("furutta", "seed=1", ConfigError, "Did you mean 'furuta'"),
        ("furuta", "model.mjcf=${conf:nix.xml}", ConfigError, "no configuration file 'nix.xml'"),
        ("furuta", "measurements.logs=[nix.mcap]", DataError, "There is no file 'nix.mcap'"),
    ],
)
def test_what_does_not_fit_is_said_as_on_the_command_line(
    model: str, given: str, error: type[Exception], told: str
) -> None:
    with pytest.raises(error, match=told):
        Comparison.load(model, "furuta", given)


def test_what_trains_and_records_says_so_as_well(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="Did you mean 'furuta_balance'"):
        train("env=furuta_balanc")
    with pytest.raises(ConfigError, match="needs an existing folder"):
        record("seed=1", config_dir=f"{tmp_path}/mine")
    with pytest.raises(ConfigError, match="is a sweep and takes -m: dr-lab train -m hparams_search=ppo"):
        train("hparams_search=ppo", "env=furuta_balance", run_dir=tmp_path / "one")
    assert not (tmp_path / "one").exists()


def test_folders_are_texts_and_effects_a_name_and_no_run_is_written_over(tmp_path: Path) -> None:
    for name in ("logs", "logs_2"):
        (made, *_) = record("plant=pendulum", "plant.duration=0.5", "plant.peaks=[2]", run_dir=f"{tmp_path}/logs")
        assert made.parent == tmp_path / name
    loaded = Comparison.load("furuta", "furuta", *SMALL)
    with pytest.raises(ConfigError, match="There is no effect 'nix'"):
        loaded.diagnose("nix")
    with pytest.raises(ConfigError, match=r"needs effects.* Options of a group bring it, of which none is chosen"):
        loaded.diagnose([])
    changed = replace(loaded, settings=replace(loaded.settings))
    reports = [each.compare(run_dir=str(tmp_path / "run")) for each in (loaded, changed, changed)]
    assert [report.run for report in reports] == [str(tmp_path / name) for name in ("run", "run_2", "run_3")]
    assert (tmp_path / "run" / "config.yaml").is_file()
    assert not (tmp_path / "run_2" / "config.yaml").exists()  # which would be that of other settings


def test_names_are_offered_for_completion() -> None:
    assert {"Comparison", "train", "evaluate", "record", "load_controller"} <= {*dir(dr_lab)}


def test_logs_are_those_of_the_command(tmp_path: Path) -> None:
    asked = ("plant=pendulum", "plant.duration=0.5", "seed=3")
    (made, *_) = record(*asked, run_dir=tmp_path / "called")
    assert main(["record", *asked, f"output={tmp_path}/typed"]) == 0
    assert made.read_bytes() == (tmp_path / "typed" / made.name).read_bytes()


@pytest.mark.slow
def test_a_policy_is_that_of_the_command_is_evaluated_and_is_no_other_run_s(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    trained = train(*SHORT)
    (folder,) = Path("outputs/train/furuta_balance").iterdir()
    assert trained.run == str(folder)
    assert from_plain(TrainReport, json.loads((folder / "report.json").read_text())) == trained
    assert main(["train", *SHORT, "hydra.run.dir=typed"]) == 0
    assert json.loads(Path("typed/report.json").read_text())["final_return"] == trained.final_return
    played = evaluate(f"run={trained.run}", "evaluator.episodes=2", "threads=1")
    assert from_plain(EvaluateReport, json.loads((Path(played.run) / "report.json").read_text())) == played
    assert played.trained == str(Path(trained.run).resolve())
    with pytest.raises(ConfigError, match="is a run with other settings"):
        train(*SHORT, "seed=1", f"resume={trained.run}", run_dir=tmp_path / "second")


def test_importing_the_package_imports_nothing_heavy() -> None:
    done = subprocess.run([sys.executable, "-c", LIGHT], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
