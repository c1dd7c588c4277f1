"""Every way in which a command can fail: one message that says what to do, an exit code, no traceback, no folder."""

import os
import signal
import sys
import time
from pathlib import Path

import pytest
from cli_machine import CommandLine, module, write

from dr_lab.errors import UnknownNameError
from dr_lab.files import atomic

Capture = pytest.CaptureFixture[str]

SAYS = {
    ("model=swin",): ["no model 'swin'", "Did you mean 'swing'?", "broken, door, swing"],
    ("effect=[wind,rst]",): ["no effect 'rst'", "Did you mean 'rust'?", "all, rust, wind"],
    ("experiment=nigth",): ["no experiment 'nigth'", "Did you mean 'night'?"],
    ("horzon=2",): ["'horzon'", "Did you mean 'horizon'?", "Available: effect, effects, experiment, horizon"],
    ("model.nmae=x",): ["'model.nmae'", "Did you mean 'model.name'?"],
    ("source=x",): ["no key or group 'source'", "effect", "model"],
    ("+new=1",): ["no key 'new' in dr-lab compare", "horizon"],
    ("+model.nmae=1",): ["no key 'model.nmae' in parts.Machine", "Did you mean 'model.name'?"],
    ("~model.name",): ["parts.Machine needs model.name"],
    ("~horizon",): ["dr-lab compare needs horizon"],
    ("horizon=???", "seed=???"): ["No value for horizon, seed", "dr-lab compare horizon=… seed=…"],
    ("horizon=${foo}",): ["horizon: Interpolation key 'foo' not found"],
    ("horizon=${oc.env:NOT_SET}",): ["horizon: \"Environment variable 'NOT_SET' not found"],
    ("horizon=long",): ["horizon is 'long'; expected a number."],
    ("horizon=-.inf",): ["horizon is '-.inf'; expected a number. On the command line write horizon=-inf; -.inf is"],
    ("threads=1e2",): ["threads is 100.0; expected a whole number or null. Write threads=100."],
    ("horizon=null",): ["horizon is null; expected a number."],
    ("+least=many", "+most=${least}", "horizon=${most}"): ["dr-lab compare: least is 'many'; "],
    ("threads=many",): ["threads is 'many'; expected a whole number or null."],
    ("names=[a,1]",): ["names is ['a', 1]; ", "expected [a text, …]."],
    ("names=a",): ["names is 'a'; expected [a text, …]. Write 'names=[a]'."],
    ("horizon=long", "threads=many", "model._target_=parts.Machin"): [
        "dr-lab compare: threads is 'many'; expected a whole number or null.\n",
        "\nThere is no name 'Machin' in parts (model._target_). Did you mean 'Machine'?",
        "\nhorizon is 'long'; expected a number.\n",
    ],
    ("outputs=null",): ["outputs is null; expected a folder. Give outputs=FOLDER, or leave it out."],
    ("hydra.run.dir=",): ["hydra.run.dir is empty; expected a folder."],
    ("model=null",): ["A group takes the name of one of its options, or a list of names"],
    ("model=mine/robot.xml",): ["names a file", "write FOLDER/model/NAME.yaml", "--config-dir FOLDER model=NAME"],
    ("somewhere/else",): ["Cannot read 'somewhere/else'; expected key=value", "dr-lab compare --help"],
    ("model.parameters={arm.mas:{low:1}}",): [
        "'model.parameters.arm.mas'",
        "Did you mean 'model.parameters.arm.mass'?",
    ],
    ("model.parameters.arm.mass.lo=1",): [
        "'model.parameters.arm.mass.lo'",
        "Did you mean 'model.parameters.arm.mass'?",
    ],
    ("model=door", "model.parameters.arm.mass=1"): [
        "model.parameters holds no key",
        "'+model.parameters={arm.mass:VALUE}'",
    ],
    ("+model.parameters={a:{low:x}}",): [
        "model.parameters is",
        "; expected {name: {name: a number, …}, …}.",
    ],
    ("model._target_=os.system",): ["'os.system' is outside the trusted packages", "DR_LAB_TRUST"],
    ("model._target_=dr_lab.errors.difflib.Differ",): ["cannot be imported"],
    ("model._target_=dr_lab.errors.Iterable",): ["outside the trusted packages"],
    ("model._target_=parts.Machin",): ["no name 'Machin'", "Did you mean 'Machine'?"],
    ("model._target_=parts.nowhere.Machine",): ["cannot be imported", "ModuleNotFoundError"],
    ("model=broken",): ["dr-lab compare: broken has no legs"],
    ("seed=1,2",): ["seed=1,2 gives several values. As a list: 'seed=[1,2]'", "--multirun"],
    ("x==",): ["Cannot read 'x=='", "expected key=value"],
    ("model.name=a[b]",): ["""'model.name="a[b]"'"""],
    ("--modle", "door"): ["no flag '--modle'", "settings have no dashes: key=value"],
    ("--multirum",): ["Did you mean '--multirun'?"],
    ("--cfg", "jobs"): ["invalid choice: 'jobs'", "Flags: --cfg"],
    ("--cfg", "job", "--multirun"): ["Only one of --run, --multirun"],
    ("--config-dir", "nowhere"): ["--config-dir needs an existing folder; given 'nowhere'"],
    ("--config-name", "nowhere"): ["'nowhere'"],
    ("model.mjcf=${conf:model/swnig.xml}",): ["'model/swnig.xml'", "Did you mean 'model/swing.xml'?"],
    ("model.mjcf=${examples:log.mcap}",): ["example", "'log.mcap'"],
}


@pytest.mark.parametrize("arguments", SAYS, ids=" ".join)
def test_says_what_is_wrong(dr_lab: CommandLine, capsys: Capture, arguments: tuple[str, ...]) -> None:
    assert dr_lab("compare", *arguments) == 2
    error = capsys.readouterr().err
    for words in SAYS[arguments]:
        assert words in error
    assert "Traceback" not in error
    assert error.startswith("dr-lab")
    assert dr_lab.calls == []
    assert [path.name for path in Path.cwd().iterdir()] in ([], ["outputs"])
    assert [path for path in Path.cwd().rglob("*") if path.name != "outputs"] == []


def test_a_value_that_several_keys_take_is_told_once(dr_lab: CommandLine, capsys: Capture) -> None:
    assert dr_lab("compare", "+least=many", "horizon=${least}", "threads=${least}") == 2
    assert capsys.readouterr().err == "dr-lab compare: least is 'many'; expected a whole number or null.\n"


def test_mandatory_group(dr_lab: CommandLine, capsys: Capture) -> None:
    assert dr_lab("add") == 2
    assert capsys.readouterr().err == (
        "dr-lab add: No effect is chosen. Give one: dr-lab add effect=NAME. Available: all, rust, wind.\n"
    )


@pytest.mark.parametrize("typed", ["place/sh", "plac/shed"])
def test_option_of_a_folder_below_its_group(dr_lab: CommandLine, capsys: Capture, tmp_path: Path, typed: str) -> None:
    shed = "_target_: parts.Machine\nname: shed\nmjcf: none\nparameters: {}\n"
    write(tmp_path / "conf/model/paved.yaml", f"defaults: [floor: tiled, /effect@other: rust]\n{shed}")
    for option in ("place/shed", "place/hall", "floor/tiled"):
        write(tmp_path / f"conf/model/{option}.yaml", shed)
    assert dr_lab("compare", f"model={typed}") == 2
    listed = "place/hall, place/shed" if typed == "place/sh" else "broken, door, paved, place/hall, place/shed, swing"
    told = f"no model '{typed}' in the configuration. Did you mean 'place/shed'? Available: {listed}.\n"
    assert told in capsys.readouterr().err
    assert dr_lab("compare", "model=place/shed") == 0
    assert dr_lab("compare", "--help") == 0
    lines = capsys.readouterr().out.splitlines()
    assert "      place/…  hall, shed" in lines
    assert not any("tiled" in line for line in lines)


def test_group_that_only_other_options_have(dr_lab: CommandLine, capsys: Capture, tmp_path: Path) -> None:
    swing = "_target_: parts.Machine\nname: swing\nmjcf: none\nparameters: {}\n"
    write(tmp_path / "conf/model/swing.yaml", f"defaults: [floor: tiled, _self_]\n{swing}")
    write(tmp_path / "conf/model/floor/tiled.yaml", "{}\n")
    assert dr_lab("compare", "model=door", "model/floor=tiled") == 2
    told = "The chosen model has no group 'model/floor'. Choose one that has, or leave it out. Available: swing.\n"
    assert told in capsys.readouterr().err


FILES = {
    "model/syntax.yaml": ("_target_: parts.Machine\n\tname: x\n", ["syntax.yaml, line 2", "indent with spaces"]),
    "model/plain.yaml": ("name: x\n", ["model names no class", "_target_: package.module.Name", "a Machine"]),
    "model/half.yaml": ("_target_: parts.Machine\nname: x\n", ["needs model.mjcf", "--cfg job -p model"]),
    "effect/sand.yaml": (
        "_target_: parts.Effect\nname: s\n",
        ["sand.yaml: its first line", "'# @package effects.sand'"],
    ),
    "effect/none.yaml": ("# @package effects.none\n", ["effects.none names no class", "an Effect"]),
    "effect/door.yaml": (
        "# @package effects.door\n_target_: parts.Machine\nname: door\nmjcf: none\n",
        ["effects.door: _target_ 'parts.Machine' is no Effect, which dr-lab compare expects there."],
    ),
}


@pytest.mark.parametrize("name", FILES)
def test_own_files_that_are_wrong(dr_lab: CommandLine, capsys: Capture, tmp_path: Path, name: str) -> None:
    text, said = FILES[name]
    write(tmp_path / "mine" / name, text)
    group, _, option = name.removesuffix(".yaml").partition("/")
    assert dr_lab("compare", "--config-dir", str(tmp_path / "mine"), f"{group}={option}") == 2
    error = capsys.readouterr().err
    for words in said:
        assert words in error


@pytest.mark.parametrize("chosen", ["all", "[rust,sand]"])
def test_misplaced_file_stops_only_those_who_ask_for_it(
    dr_lab: CommandLine, capsys: Capture, tmp_path: Path, chosen: str
) -> None:
    write(tmp_path / "mine/effect/sand.yaml", "# sand\n_target_: parts.Effect\nname: sand\n")
    mine = ("--config-dir", str(tmp_path / "mine"))
    assert dr_lab("add", *mine, "effect=rust") == 0
    assert dr_lab("compare", *mine, "effect=[rust,wind]") == 0
    assert dr_lab("compare", *mine, f"effect={chosen}") == 2
    assert "sand.yaml: its first line must be '# @package effects.sand'" in capsys.readouterr().err
    assert len(dr_lab.calls) == 2


def test_experiment_of_another_verb(dr_lab: CommandLine, capsys: Capture, tmp_path: Path) -> None:
    text = "# @package _global_\n# a day\n# dr-lab polish experiment=day\ndefaults: [{override /cloth: soft}]\n"
    write(tmp_path / "conf/experiment/day.yaml", text)
    assert dr_lab("compare", "experiment=day") == 2
    error = capsys.readouterr().err
    assert "Experiment 'day' is not one of dr-lab compare, which has no group 'cloth'" in error
    assert "Its own command: dr-lab polish experiment=day" in error


def test_unknown_verb(dr_lab: CommandLine, capsys: Capture) -> None:
    assert dr_lab("comapre") == 2
    assert "Did you mean 'compare'? Available: add, compare." in capsys.readouterr().err


def test_verb_without_workflow(dr_lab: CommandLine, capsys: Capture, tmp_path: Path) -> None:
    write(tmp_path / "conf/polish.yaml", "# polish it\ndefaults: [{base: hydra}, _self_]")
    assert dr_lab("polish") == 2
    assert "dr_lab.workflows.polish does not exist" in capsys.readouterr().err


def test_traceback_on_request(dr_lab: CommandLine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HYDRA_FULL_ERROR", "1")
    with pytest.raises(Exception, match="broken has no legs"):
        dr_lab("compare", "model=broken")


def test_traceback_on_request_from_our_own_errors(dr_lab: CommandLine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HYDRA_FULL_ERROR", "1")
    with pytest.raises(UnknownNameError, match="no key 'new'"):
        dr_lab("compare", "+new=1")


def fail(error: BaseException, monkeypatch: pytest.MonkeyPatch) -> None:
    def compare(run_dir: Path, **everything: object) -> None:
        raise error

    name = "dr_lab.workflows.compare"
    monkeypatch.setitem(sys.modules, name, module(name, compare=compare))


def test_fault_of_ours_keeps_the_run_folder(
    dr_lab: CommandLine, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    fail(ZeroDivisionError("by zero"), monkeypatch)
    assert dr_lab("compare") == 1
    error = capsys.readouterr().err
    assert error.startswith("dr-lab compare: ZeroDivisionError: by zero\n")
    assert "HYDRA_FULL_ERROR=1" in error
    assert len(list(Path("outputs").rglob("config.yaml"))) == 1


def test_interrupt(dr_lab: CommandLine, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    fail(KeyboardInterrupt(), monkeypatch)
    assert dr_lab("compare") == 130
    assert capsys.readouterr().err.strip() == "dr-lab: interrupted."


def test_termination_leaves_no_half_written_file(
    dr_lab: CommandLine, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def compare(run_dir: Path, **everything: object) -> None:
        with atomic(run_dir / "report.json") as temporary:
            temporary.write_text("half")
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(60)

    before = signal.getsignal(signal.SIGTERM)
    name = "dr_lab.workflows.compare"
    monkeypatch.setitem(sys.modules, name, module(name, compare=compare))
    assert dr_lab("compare") == 143
    assert capsys.readouterr().err.strip() == "dr-lab: terminated."
    assert [path.name for path in Path("outputs").rglob("*") if path.is_file()] == ["config.yaml"]
    assert signal.getsignal(signal.SIGTERM) == before


@pytest.mark.parametrize("outputs", ["there", "../here/there"])
def test_what_cannot_be_run_leaves_no_folder(dr_lab: CommandLine, outputs: str) -> None:
    assert dr_lab("compare", "horizon=long", f"outputs={outputs}") == 2
    assert [path for path in Path.cwd().rglob("*") if path.name != "there"] == []


@pytest.mark.parametrize("typed", ["outputs=taken", "hydra.run.dir=taken", "hydra.run.dir=taken/below"])
def test_output_that_is_a_file(dr_lab: CommandLine, capsys: Capture, typed: str) -> None:
    Path("taken").touch()
    assert dr_lab("compare", typed) == 2
    error = capsys.readouterr().err
    assert "Cannot make the run folder taken" in error
    assert ": taken is a file. Choose another place: outputs=FOLDER, or hydra.run.dir=" in error


@pytest.mark.parametrize("typed", ["outputs=taken", "hydra.sweep.dir=taken"])
def test_folder_of_a_sweep_that_is_a_file(dr_lab: CommandLine, capsys: Capture, typed: str) -> None:
    Path("taken").touch()
    assert dr_lab("compare", "-m", "seed=1,2", typed) == 2
    error = capsys.readouterr().err
    assert "Cannot make the sweep's folder " in error
    assert "/taken is a file. Choose another place: outputs=FOLDER, or hydra.sweep.dir=" in error


def test_environment_is_left_as_it_was(dr_lab: CommandLine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("HYDRA_FULL_ERROR", raising=False)
    before = dict(os.environ)
    dr_lab("compare")
    assert dict(os.environ) == before
