"""What goes wrong first: files, topics, units, models and folders that cannot be used, each with one clear message."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from dr_lab.__main__ import main
from dr_lab.errors import DataError
from dr_lab.recorders.mcap import write_mcap

Capture = pytest.CaptureFixture[str]
Refused = Callable[..., str]
EXAMPLES = Path(__file__).parents[2] / "examples" / "furuta"
SMALL = ("windows.seconds=0.6", "measurements.fit=[log_1]", "measurements.held_out=[]")
TIME = np.arange(0.0, 4.0, 0.002)
SWING = np.cos(5.0 * TIME)


@pytest.fixture
def refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> Refused:
    """Run `dr-lab` with arguments that it must refuse; gives its message."""
    monkeypatch.delenv("HYDRA_FULL_ERROR", raising=False)
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")

    def run(verb: str, *arguments: str, lines: int = 1) -> str:
        assert main([verb, *arguments]) == 2
        out, error = capsys.readouterr()
        assert all(line.endswith(" …") for line in out.splitlines())  # no more than what it was at
        assert error.startswith(f"dr-lab {verb}: ")
        assert len(error.splitlines()) == lines
        assert "Traceback" not in error
        left = {path.name for path in Path.cwd().rglob("*") if path.is_file()}
        assert left <= {"config.yaml"}
        return error

    return run


def named(*files: Path) -> list[str]:
    """Overrides that read files without a split."""
    paths = ",".join(map(str, files))
    return [f"measurements.logs=[{paths}]", "measurements.fit=null", "measurements.held_out=null", SMALL[0]]


def table(path: Path, **columns: object) -> list[str]:
    """Write a CSV file and give the overrides that read its arm and voltage."""
    rows = np.broadcast_arrays(*[np.asarray(column, dtype=float) for column in columns.values()])
    text = "\n".join(",".join(f"{value:.9g}" for value in row) for row in zip(*rows, strict=True))
    path.write_text(",".join(columns) + "\n" + text + "\n")
    channels = "{arm.position:{column:arm,unit:rad}}", "{motor:{column:u,unit:V}}"
    entries = [f"+measurements.{key}={value}" for key, value in zip(("outputs", "commands"), channels, strict=True)]
    return [*named(path), "measurements.clock=null", "~measurements.outputs", "~measurements.commands", *entries]


def test_missing_file(refused: Refused, tmp_path: Path) -> None:
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs/monday.mcap").touch()
    error = refused("compare", *named(tmp_path / "logs/munday.mcap"))
    assert f"There is no file '{tmp_path}/logs/munday.mcap'; folder {tmp_path}/logs holds monday.mcap." in error


@pytest.mark.parametrize("content", ["bytes", "messages"])
def test_empty_mcap(refused: Refused, tmp_path: Path, content: str) -> None:
    path = tmp_path / "empty.mcap"
    path.touch()
    if content == "messages":
        write_mcap(path, [], {}, {})
    said = {"bytes": "is empty (0 bytes)", "messages": "holds no messages"}[content]
    error = refused("compare", *named(path))
    assert f"{path} {said}. Record it again, or leave it out of logs." in error


def test_cut_mcap_is_recovered_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    whole = (EXAMPLES / "log_1.mcap").read_bytes()
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole[: int(0.7 * len(whole))])
    assert main(["compare", *named(path), "hydra.run.dir=run"]) == 0
    said = " ".join(capfd.readouterr().out.split())
    assert "cut.mcap ends early (interrupted recording);" in said
    assert "complete messages were recovered" in said
    (note,) = [n for n in json.loads((tmp_path / "run/report.json").read_text())["notes"] if n["kind"] == "cut"]
    assert 2000 < note["count"] < 4500
    assert "cut.mcap ends early" in (tmp_path / "run/report.md").read_text(encoding="utf-8")


def test_topic_that_is_not_in_the_file(refused: Refused) -> None:
    error = refused("compare", *SMALL, "measurements.outputs.arm.position.topic=/joint_sates")
    assert "There is no topic '/joint_sates' in log_1.mcap. Did you mean '/joint_states'?" in error
    assert "Available: /joint_states, /motor_voltage." in error


def test_joint_that_is_misspelt(refused: Refused) -> None:
    in_file = refused("compare", *SMALL, 'measurements.outputs.arm.position.field="position[amr]"')
    assert "There is no joint 'amr' in topic '/joint_states'" in in_file
    assert "Did you mean 'arm'? Available: arm, pole." in in_file
    outputs = '{ram.position:{topic:/joint_states,field:"position[arm]",unit:rad}}'
    in_model = refused("compare", *SMALL, "~measurements.outputs", f"+measurements.outputs={outputs}")
    assert "There is no output 'ram.position' in the model" in in_model
    assert "Did you mean 'arm.position'?" in in_model


def test_degrees_that_are_radians(refused: Refused) -> None:
    error = refused("compare", *SMALL, "measurements.outputs.arm.position.unit=deg")
    assert "arm.position is declared 'deg'" in error
    assert "the factor 57.3 = 180/π is suspected. Write unit: rad" in error


def test_radians_that_are_degrees(refused: Refused, tmp_path: Path) -> None:
    error = refused("compare", *table(tmp_path / "deg.csv", time=TIME, arm=np.rad2deg(SWING), u=0.0))
    assert "arm.position (declared 'rad') turns at" in error
    assert "the factor 57.3 = 180/π is suspected. Write unit: deg" in error


def test_commands_and_outputs_of_different_times(refused: Refused) -> None:
    error = refused("compare", *SMALL, "measurements.commands.motor.latency=100")
    assert "Log 'log_1': 'motor' (-99.9" in error
    assert "do not overlap in time" in error
    assert "(log and header) do not agree, choose another clock for one of them: header or publish or log." in error


def test_channel_of_nothing_but_nan(refused: Refused, tmp_path: Path) -> None:
    error = refused("compare", *table(tmp_path / "nan.csv", time=TIME, arm=np.nan, u=0.0))
    assert "Log 'nan': channel 'arm.position': all 2000 cells are empty or no finite numbers. Check its column" in error


def test_one_sample(refused: Refused, tmp_path: Path) -> None:
    error = refused("compare", *table(tmp_path / "one.csv", time=[0.0], arm=[1.0], u=[0.0]))
    assert "Log 'one': channel 'arm.position' (column arm) has 1 usable samples; at least 20 are needed." in error


def test_model_that_does_not_compile(refused: Refused, tmp_path: Path) -> None:
    path = tmp_path / "broken.xml"
    path.write_text('<mujoco>\n<worldbody>\n<body><joint name="arm"/></body>\n</worldbody>\n</mujoco>')
    error = refused("compare", *SMALL, f"model.mjcf={path}", lines=2)
    assert "Model 'furuta' does not compile (broken.xml):" in error
    assert "mass and inertia of moving bodies must be larger than mjMINVAL" in error
    assert "line 3" in error


def test_parameter_that_changes_nothing(refused: Refused) -> None:
    # The arm has an explicit inertia, which a density of its geometry does not change.
    idle = "{arm.mass:{target:geom.arm.density,unit:g/l,low:500.0,high:2000.0}}"
    error = refused("fit", *SMALL, f"model.parameters={idle}")
    assert "Parameter 'arm.mass' of model 'furuta' changes nothing between 500 and 2000." in error
    assert "Point its target at something the physics uses, or delete it." in error


@pytest.mark.parametrize("key", ["outputs", "hydra.run.dir"])
def test_run_folder_that_cannot_be_made(refused: Refused, tmp_path: Path, key: str) -> None:
    (tmp_path / "file").write_text("taken")
    error = refused("compare", *SMALL, f"{key}={tmp_path}/file/runs")
    assert f"Cannot make the run folder {tmp_path}/file/runs" in error
    assert "is a file. Choose another place: outputs=FOLDER" in error
    assert (tmp_path / "file").read_text() == "taken"


def test_logs_that_cannot_be_written(refused: Refused, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("taken")
    error = refused("record", "plant.duration=0.5", f"output={tmp_path}/file/logs")
    assert f"Cannot write {tmp_path}/file/logs/log_1.mcap: Not a directory. Choose a folder" in error


NUMBERS = {
    "windows.length=-1": "windows.length is -1; expected a number above 0.",
    "windows.length=20": "No log holds one gapless window of 20 s",
    "windows.longest=0": "windows.longest is 0; expected a number above 0.",
    "windows.seconds=0": "windows.seconds is 0; expected a number above 0.",
    "solver.iterations=0": "solver.iterations is 0; expected at least 1.",
    "evidence.confidence=95": "evidence.confidence is 95; expected a share between 0 and 1, such as 0.95.",
    "localise.least=2": "localise.least is 2; expected a share between 0 and 1.",
    "recorder.pose_rate=0": "recorder.pose_rate is 0; expected a number above 0.",
    "threads=-2": "threads is -2; expected at least 1, or null for all cores.",
    "measurements.outputs.arm.position.noise_std=0": "noise_std must be > 0; got 0. Write null to estimate it.",
    "measurements.outputs.arm.position.noise_std=small": "noise_std is 'small'; expected a number.",
    "measurements.fit=[]": "Neither fit nor held_out names a log; give at least one of: log_1,",
    "measurements.held_out=[log5]": "There is no log 'log5' in logs. Did you mean 'log_5'?",
    "measurements.clock=heder": "There is no clock 'heder' in the entry of channel 'arm.position'. Did you mean",
}


# More numbers out of their bounds, which other settings' bounds refuse alike.
ALIKE = ("windows.longest=0", "windows.seconds=0", "localise.least=2", "recorder.pose_rate=0", "threads=-2")


@pytest.mark.parametrize(
    "override", [pytest.param(each, marks=[pytest.mark.slow] if each in ALIKE else []) for each in NUMBERS]
)
def test_values_that_cannot_be(refused: Refused, override: str) -> None:
    assert NUMBERS[override] in refused("compare", *SMALL, override)


SITES = {
    (): "Effect 'coulomb_friction' needs one site; given: nothing. Available: arm, pole. Say e.g. effect.joint=arm.",
    ("effect.joint=amr",): "There is no site for coulomb_friction 'amr' in the model. Did you mean 'arm'?",
    ("effect.actuator=motor",): "There is no site for coulomb_friction 'motor' in the model. Available: arm, pole.",
    ("effect.joint=arm", "effect.body=arm"): "needs one site; given: effect.joint=arm, effect.body=arm.",
    ("effect.site=arm",): "Did you mean 'effect.joint'?",
}


@pytest.mark.parametrize("site", SITES)
def test_effects_at_places_that_are_not_there(refused: Refused, site: tuple[str, ...]) -> None:
    assert SITES[site] in refused("add", *SMALL, "effect=coulomb_friction", *site)


def test_commands_for_a_model_without_actuators(refused: Refused, tmp_path: Path) -> None:
    path = tmp_path / "free.xml"
    path.write_text('<mujoco><worldbody><body><joint name="arm"/><geom size="0.1"/></body></worldbody></mujoco>')
    error = refused("compare", *SMALL, f"model.mjcf={path}", "~model.parameters", "+model.parameters={}")
    assert (
        "There is no actuator 'motor' in the model (a command is named after its actuator). Available: none." in error
    )


def test_nothing_to_fit_on(refused: Refused) -> None:
    error = refused("compare", *SMALL, "measurements.fit=[]", "measurements.held_out=[log_5]")
    assert "Measurements 'furuta' name no log to fit on. Name at least one in measurements.fit." in error


def test_any_mjcf_can_be_compared_though_nothing_in_it_has_a_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.chdir(tmp_path)
    xml = '<mujoco><worldbody><body><joint axis="0 1 0" pos="0 0 1"/><geom size="0.1"/></body></worldbody></mujoco>'
    (tmp_path / "free.xml").write_text(xml)
    read = table(tmp_path / "log.csv", time=TIME, arm=SWING + 0.01 * np.sin(900.0 * TIME), u=0.0)[:-2]
    channel = "+measurements.outputs={joint_0.position:{column:arm,unit:rad}}"
    model = [f"model.mjcf={tmp_path}/free.xml", "~model.parameters", "+model.parameters={}"]
    assert main(["compare", *read, channel, *model, "hydra.run.dir=run"]) == 0, capsys.readouterr().err
    assert (tmp_path / "run/review.rrd").is_file()


def test_traceback_where_it_is_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HYDRA_FULL_ERROR", "1")
    shutil.copy(EXAMPLES / "truth.yaml", tmp_path / "log.mcap")
    with pytest.raises(Exception, match="is not an MCAP file") as caught:
        main(["compare", *named(tmp_path / "log.mcap")])
    assert isinstance(caught.value, DataError) or isinstance(caught.value.__cause__, DataError)


def test_number_of_effects_below_none(refused: Refused) -> None:
    error = refused("close", *SMALL, "most=-1")
    assert "most is -1; expected the number of effects to add at most, 0 or more." in error
