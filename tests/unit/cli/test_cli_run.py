"""From a command to the call of a workflow, and what the run folder holds."""

import csv
import shlex
import sys
from pathlib import Path

import hydra
import mujoco
import pytest
import yaml
from cli_machine import CommandLine, Machine, module, write
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra.core.global_hydra import GlobalHydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from omegaconf import DictConfig

from dr_lab.cli.compose import compose


def only(folder: Path) -> Path:
    """The one entry of a folder."""
    (entry,) = folder.iterdir()
    return entry


def test_workflow_gets_every_top_level_key(dr_lab: CommandLine) -> None:
    assert dr_lab("compare", "horizon=2", "names=[x,y]") == 0
    (call,) = dr_lab.calls
    assert call["model"] == Machine("swing", call["model"].mjcf, {"arm.mass": {"low": 1.0, "high": 2.0}})
    assert Path(call["model"].mjcf).is_file()
    assert sorted(call["effects"]) == ["rust", "wind"]
    assert (call["horizon"], call["names"], call["seed"], call["threads"]) == (2, ["x", "y"], 0, None)
    assert type(call["names"]) is list


def test_one_run_is_composed_once(dr_lab: CommandLine, monkeypatch: pytest.MonkeyPatch) -> None:
    composed, compose_anew = list[object](), ConfigLoaderImpl._load_configuration_impl

    def counted(*given: object, **named: object) -> DictConfig:
        composed.append(named)
        return compose_anew(*given, **named)  # pyright: ignore[reportArgumentType]

    monkeypatch.setattr(ConfigLoaderImpl, "_load_configuration_impl", counted)
    assert dr_lab("compare", "horizon=2") == 0
    assert len(composed) == 1
    assert dr_lab.calls[0]["horizon"] == 2


def test_run_dir_is_named_by_verb_model_and_time_and_holds_only_the_config(dr_lab: CommandLine) -> None:
    dr_lab("compare", "model=door")
    run_dir = dr_lab.calls[0]["run_dir"]
    assert run_dir.parent == Path("outputs/compare/door").absolute()
    assert [path.name for path in run_dir.iterdir()] == ["config.yaml"]


@pytest.mark.parametrize("files", [[], ["report.html", "review.rrd"]])
def test_the_end_says_where_the_run_is_and_how_to_look_at_what_it_recorded(
    files: list[str], dr_lab: CommandLine, capsys: pytest.CaptureFixture[str]
) -> None:
    dr_lab.files = files
    assert dr_lab("compare", "hydra.run.dir=my runs/first") == 0
    told = capsys.readouterr().out
    assert "\nRun folder: my runs/first\n" in told
    assert ("\nReport to send: my runs/first/report.html\n" in told) == bool(files)
    assert ("\nLook at it: dr-lab view 'run=my runs/first'\n" in told) == bool(files)


def test_a_folder_with_signs_is_told_as_it_must_be_typed(
    dr_lab: CommandLine, capsys: pytest.CaptureFixture[str]
) -> None:
    dr_lab.files = ["review.rrd"]
    assert dr_lab("compare", "hydra.run.dir='a=1,b(2)'") == 0
    told = capsys.readouterr().out.split("Look at it: dr-lab view ")[1]
    [typed] = shlex.split(told)
    assert OverridesParser.create().parse_override(typed).value() == "a=1,b(2)"


def test_config_records_versions_and_the_command(dr_lab: CommandLine) -> None:
    dr_lab("compare", "seed=5")
    text = (dr_lab.calls[0]["run_dir"] / "config.yaml").read_text()
    config = yaml.safe_load(text)
    assert text.startswith("# dr-lab compare seed=5\n")
    assert config["seed"] == 5
    assert config["model"]["mjcf"] == "${conf:model/swing.xml}"
    versions = config["made_with"]["versions"]
    assert versions["mujoco"] == mujoco.__version__
    assert sorted(versions) == ["dr_lab", "mujoco", "numpy", "python", "rerun", "scipy"]


def test_run_repeats_exactly_from_its_folder(dr_lab: CommandLine) -> None:
    dr_lab("compare", "experiment=night", "horizon=3", "effect=wind")
    first = dr_lab.calls[0]
    assert dr_lab("compare", "--config-dir", str(first["run_dir"]), "--config-name", "config") == 0
    second = dr_lab.calls[1]
    assert second.pop("run_dir") != first.pop("run_dir")
    assert second == first
    assert second["seed"] == 7


def test_two_runs_never_share_a_folder(dr_lab: CommandLine) -> None:
    for _ in range(3):
        dr_lab("compare", "hydra.run.dir=outputs/mine")
    assert [call["run_dir"].name for call in dr_lab.calls] == ["mine", "mine_2", "mine_3"]


@pytest.mark.parametrize(
    ("typed", "place"),
    [
        ("hydra.run.dir='~/mine'", "mine"),
        ("outputs='~/mine'", "mine/compare/*/*"),
        ("-m seed=1 hydra.sweep.dir='~/mine'", "mine/0"),
        ("-m seed=1 outputs='~/mine'", "mine/multirun/compare/*/0"),
    ],
)
def test_results_lie_below_the_home_that_a_tilde_names(
    dr_lab: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, typed: str, place: str
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    assert dr_lab("compare", *typed.split()) == 0
    assert [path.name for path in tmp_path.glob(f"{place}/config.yaml")] == ["config.yaml"]
    assert not Path("~").exists()


def test_effect_selects_the_yaml_and_effect_joint_its_site(dr_lab: CommandLine) -> None:
    assert dr_lab("add", "effect=rust", "effect.joint=arm") == 0
    assert list(dr_lab.calls[0]["effects"]) == ["rust"]
    assert dr_lab.calls[0]["effect"] == {"joint": "arm"}


def test_several_effects_at_once(dr_lab: CommandLine) -> None:
    dr_lab("add", "effect=[wind,rust]")
    assert sorted(dr_lab.calls[0]["effects"]) == ["rust", "wind"]


def test_new_effect_file_joins_the_whole_catalogue(dr_lab: CommandLine, tmp_path: Path) -> None:
    write(tmp_path / "mine/effect/sand.yaml", "# @package effects.sand\n_target_: parts.Effect\nname: sand\n")
    dr_lab("compare", "--config-dir", str(tmp_path / "mine"))
    assert sorted(dr_lab.calls[0]["effects"]) == ["rust", "sand", "wind"]


@pytest.mark.parametrize("flag", ["--config-dir", "-cd"])
def test_users_files_hide_ours_of_the_same_name(dr_lab: CommandLine, tmp_path: Path, flag: str) -> None:
    mine = tmp_path / "mine"
    write(mine / "model/swing.yaml", "_target_: parts.Machine\nname: my_swing\nmjcf: ${conf:model/swing.xml}\n")
    write(mine / "model/swing.xml", "<mujoco/>")
    dr_lab("compare", f"{flag}={mine}")
    assert dr_lab.calls[0]["model"] == Machine("my_swing", str(mine / "model/swing.xml"))


def test_multirun_runs_every_combination(dr_lab: CommandLine) -> None:
    assert dr_lab("compare", "-m", "seed=1,2", "model=swing,door") == 0
    assert [(c["seed"], c["model"].name) for c in dr_lab.calls] == [
        (1, "swing"),
        (1, "door"),
        (2, "swing"),
        (2, "door"),
    ]
    assert dr_lab.calls[3]["run_dir"].relative_to(Path.cwd()).parts[:3] == ("outputs", "multirun", "compare")
    assert dr_lab.calls[3]["run_dir"].name == "3"


@pytest.mark.slow
def test_multirun_over_a_name_with_a_dot(dr_lab: CommandLine) -> None:
    swept = ("model.parameters.arm.mass.low=1.25,1.5", "model.parameters.arm.mass.high=3.0,4.0")
    assert dr_lab("compare", "-m", *swept, "hydra.sweep.dir=swept") == 0
    found = [call["model"].parameters["arm.mass"] for call in dr_lab.calls]
    assert found == [{"low": low, "high": high} for low in (1.25, 1.5) for high in (3.0, 4.0)]
    with Path("swept/sweep.csv").open(encoding="utf-8") as file:
        rows = [(r["model.parameters.arm.mass.low"], r["model.parameters.arm.mass.high"]) for r in csv.DictReader(file)]
    assert rows == [("1.25", "3.0"), ("1.25", "4.0"), ("1.5", "3.0"), ("1.5", "4.0")]


def test_multirun_goes_on_after_a_failed_job(dr_lab: CommandLine, capsys: pytest.CaptureFixture[str]) -> None:
    assert dr_lab("compare", "-m", "model=broken,door") == 2
    assert [call["model"].name for call in dr_lab.calls] == ["door"]
    assert "job 0 (model=broken) failed: broken has no legs" in capsys.readouterr().err


def test_key_that_feeds_another_need_not_be_a_parameter(dr_lab: CommandLine) -> None:
    assert dr_lab("compare", "+least=4", "horizon=${least}") == 0
    assert dr_lab.calls[0]["horizon"] == 4


def test_names_with_a_dot_can_be_overridden(dr_lab: CommandLine) -> None:
    assert dr_lab("compare", "model.parameters.arm.mass.low=1.5", "seed=3") == 0
    assert dr_lab.calls[0]["model"].parameters == {"arm.mass": {"low": 1.5, "high": 2.0}}
    assert dr_lab.calls[0]["seed"] == 3


def test_names_with_a_dot_in_notebooks(dr_lab: CommandLine) -> None:
    assert compose("compare", ["model.parameters.arm.mass.low=1.5"]).model.parameters["arm.mass"].low == 1.5
    assert dr_lab.calls == []


def test_composing_within_a_job_leaves_hydra_as_it_was(dr_lab: CommandLine, tmp_path: Path) -> None:
    with hydra.initialize_config_dir(str(tmp_path / "conf"), version_base="1.3"):
        running = GlobalHydra.instance().hydra
        compose("compare")
        assert GlobalHydra.instance().hydra is running
    assert dr_lab.calls == []


def test_cfg_prints_and_runs_nothing(dr_lab: CommandLine, capsys: pytest.CaptureFixture[str]) -> None:
    assert dr_lab("compare", "--cfg", "job", "seed=9") == 0
    assert yaml.safe_load(capsys.readouterr().out)["seed"] == 9
    assert dr_lab.calls == []
    assert list(Path.cwd().iterdir()) == []


def test_verb_without_run_dir_makes_no_folder(
    dr_lab: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = []
    write(
        tmp_path / "conf/view.yaml", "# look\ndefaults: [{base: hydra}, _self_]\nrun: latest\nhydra: {run: {dir: .}}\n"
    )
    viewer = module("dr_lab.workflows.view", view=lambda run, outputs: calls.append((run, outputs)))
    monkeypatch.setitem(sys.modules, "dr_lab.workflows.view", viewer)
    assert dr_lab("view", "outputs=there") == 0
    assert calls == [("latest", "there")]
    assert list(Path.cwd().iterdir()) == []
