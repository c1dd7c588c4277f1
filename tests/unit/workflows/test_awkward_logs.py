"""Logs that are short, slow, blind or silent still give a report."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from diagnosis_machines import (
    NOISE,
    dragged,
    log_of,
    measured,
    model_of,
    pendulum,
    short_comparison,
    simulated,
    slow_then_fast,
    solver_settings,
    swinging,
)
from effect_machines import catalogue_effect
from hydra.utils import instantiate
from recorder_samples import read_recording

from dr_lab.cli.compose import compose
from dr_lab.comparison.study import prepare
from dr_lab.errors import DrLabError, ModelError
from dr_lab.physics.model import Model
from dr_lab.recorders.look import Look
from dr_lab.reports.gap import GapReport
from dr_lab.trajectory import Log, MeasurementSet
from dr_lab.workflows.add import add
from dr_lab.workflows.fit import fit

TRUTH = np.array([0.6, 0.08])
BLIND = """<mujoco model="blind"><compiler angle="radian"/><option timestep="0.002" integrator="RK4"/>
  <worldbody><body name="rod">
    <inertial mass="0.5" pos="0 0 -0.3" diaginertia="0.005 0.005 0.001"/>
    <joint name="hinge" axis="0 1 0" damping="0.05"/><site name="imu"/>
  </body></worldbody>
  <sensor><gyro name="gyro" site="imu"/><framequat name="pose" objtype="site" objname="imu"/></sensor></mujoco>"""
DAMPING = {"hinge.damping": {"target": "joint.hinge.damping", "unit": "N·m·s/rad", "low": 0.0, "high": 0.5}}


@cache
def look(*overrides: str) -> Look:
    return instantiate(compose("fit", list(overrides)).recorder)


def fitted(model: Model, data: MeasurementSet, folder: Path, *recorder: str) -> GapReport:
    return fit(short_comparison(model, data), look(*recorder), folder)


def logs(seconds: float = 3.0) -> list[Log]:
    return [swinging(f"log_{k}", pendulum().compile(TRUTH), k, seconds=seconds) for k in range(2)]


def slow(log: Log) -> Log:
    """33 samples a second, fewer in a window than lags of the correlation."""
    signal = log.outputs["hinge.position"]
    return log_of(log.name, {signal.name: (signal.time[::15], signal.value[::15])}, log.commands["drive"])


def with_a_short_one(data: MeasurementSet) -> MeasurementSet:
    short = swinging("short", pendulum().compile(TRUTH), 9, seconds=0.3)
    return replace(data, fit=(*data.fit, short), held_out=(short, *data.held_out))


CASES: dict[str, Callable[[], MeasurementSet]] = {
    "slow": lambda: measured([slow(logs()[0])], [slow(logs()[1])]),
    "short": lambda: with_a_short_one(measured(logs()[:1], logs()[1:])),
    "none held out": lambda: measured(logs()),
}


@pytest.mark.parametrize(
    "case", [*(pytest.param(case, marks=pytest.mark.slow) for case in ("slow", "short")), "none held out"]
)
def test_awkward_logs_give_values_and_a_report(case: str, tmp_path: Path) -> None:
    report = fitted(pendulum(), CASES[case](), tmp_path)
    assert 0.3 < (report.ladder[0].held_out.chi2 or 0.0) < 2.0
    values = report.ladder[0].parameters
    assert values["rod.mass"].value == pytest.approx(TRUTH[0], rel=0.05)
    scatter, ended = values["rod.mass"].scatter, report.ladder[0].fit
    assert scatter is not None
    assert set(scatter.per_log) <= {"log_0", "log_1"}
    assert ended is not None
    assert (ended.converged, ended.infeasible_windows) == (True, 0)
    assert not {"infeasible_windows", "not_converged"} & {note.kind for note in report.notes}
    assert (tmp_path / "report.json").is_file()
    assert (tmp_path / "review.rrd").is_file()
    assert not {"no_command", "no_output"} & {note.kind for note in report.notes}


@pytest.mark.slow
def test_nothing_is_called_held_out_where_nothing_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = add(
        short_comparison(pendulum(), measured([slow(log) for log in logs(1.5)])),
        {"viscous_friction": catalogue_effect("viscous_friction")},
        {"joint": "hinge"},
        look(),
        tmp_path,
    )
    assert "on the fit logs" in report.judged.reason
    (said,) = [note.message for note in report.notes if note.kind == "no_held_out"]
    shown = str(read_recording(tmp_path / "review.rrd"))
    for text in (capsys.readouterr().out, (tmp_path / "report.md").read_text(), shown):
        told = " ".join(text.split())
        assert "χ² on fit logs" in told
        assert not re.search("held.out", told.replace(said, ""))


@pytest.mark.slow
def test_of_a_long_log_the_beginning_is_shown_and_the_note_says_so(tmp_path: Path) -> None:
    report = fitted(pendulum(), measured(logs()[:1], logs()[1:]), tmp_path, "recorder.longest=1.0")
    (note,) = [note for note in report.notes if note.kind == "shown"]
    assert (note.log, note.message[:45]) == ("log_1", "The recordings show it up to 1 s of 3 s; reco")
    path = read_recording(tmp_path / "review.rrd")["/log_1/signal/hinge.position/measured"]
    assert max(path["t"]) == pytest.approx(1.0)


@pytest.mark.slow
def test_where_commands_begin_after_what_is_shown_the_first_window_on_is_shown(tmp_path: Path) -> None:
    late = logs()[1]
    (command,) = late.commands.values()
    kept = command.time >= 1.5
    late = replace(late, commands={command.name: replace(command, time=command.time[kept], value=command.value[kept])})
    report = fitted(pendulum(), measured(logs()[:1], [late]), tmp_path, "recorder.longest=1.0")
    (note,) = [note for note in report.notes if note.kind == "shown"]
    assert note.message.startswith("The recordings show it up to 3 s of 3 s;")
    path = read_recording(tmp_path / "review.rrd")["/log_1/signal/hinge.position/measured"]
    assert max(path["t"]) == pytest.approx(2.56, abs=0.003)  # 1.5 s + 0.06 s of commands before the first window + 1 s


@pytest.mark.slow
def test_a_log_too_long_for_any_window_that_may_be_shown_is_left_out_and_the_report_stands(tmp_path: Path) -> None:
    report = fitted(pendulum(), measured(logs()[:1], logs()[1:]), tmp_path, "recorder.longest=0.2")
    (note,) = [note for note in report.notes if note.kind == "shown"]
    assert note.log == "log_1"
    assert "leave it out: it holds no gapless window within recorder.longest=0.2 s" in note.message
    assert {"report.json", "review.rrd", "simulated.mcap", "model.xml"} <= {path.name for path in tmp_path.iterdir()}


def test_the_report_is_written_before_the_recordings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: object) -> None:
        raise DrLabError("unplayable")

    monkeypatch.setattr("dr_lab.comparison.finish.play_log", fails)
    with pytest.raises(DrLabError, match="unplayable"):
        fitted(pendulum(), measured(logs()[:1], logs()[1:]), tmp_path)
    assert (tmp_path / "report.json").is_file()


def test_actuators_and_joints_that_no_channel_shows_are_told(tmp_path: Path) -> None:
    model = model_of(
        BLIND.replace("<sensor>", '<actuator><motor name="fan" joint="hinge"/></actuator><sensor>'), DAMPING
    )
    motion = simulated(model.compile(np.array([0.08])), None, 2.0, qpos=[0.6])
    read = motion["sensordata"][:, :3] + NOISE * np.random.default_rng(0).normal(size=(1000, 3))
    data = measured([log_of("log_0", {"sensor.gyro": (motion["time"], read)})])
    notes = {note.kind: note.message for note in fitted(model, data, tmp_path).notes}
    assert (
        "No command is measured for fan: simulated with the control 0. Measured commands: none." in notes["no_command"]
    )
    assert "No position or velocity is measured of joint hinge" in notes["no_output"]
    assert "Measured: sensor.gyro." in notes["no_output"]


@pytest.mark.slow
def test_an_imu_alone_without_commands_is_enough(tmp_path: Path) -> None:
    model = model_of(BLIND, DAMPING)
    found = []
    for k in range(2):
        motion = simulated(model.compile(np.array([0.08])), None, 2.0, qpos=[0.6 + 0.2 * k])
        read = motion["sensordata"] + NOISE * np.random.default_rng(k).normal(size=(1000, 7))
        channels = {"sensor.gyro": (motion["time"], read[:, :3]), "sensor.pose": (motion["time"], read[:, 3:])}
        found.append(log_of(f"log_{k}", channels))
    data = measured(found[:1], found[1:])
    scales = prepare(short_comparison(model, data)).scales
    assert (scales.unmeasured, scales.unknown) == ({"hinge"}, set())
    assert 1.0 < scales.speed["hinge"] < 4.0  # rad/s, of swings from 0.6 rad
    report = fitted(model, data, tmp_path)
    assert report.ladder[0].held_out.chi2 == pytest.approx(1.0, abs=0.1)
    assert report.ladder[0].parameters["hinge.damping"].value == pytest.approx(0.08, rel=0.03)
    assert report.failing.where == ()


def test_windows_that_diverge_are_counted_in_the_report_and_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = measured([slow_then_fast("log_0", 0)], [slow_then_fast("log_1", 1)])
    report = fitted(dragged(0.005, high=0.006), data, tmp_path)
    ended = report.ladder[0].fit
    assert ended is not None
    assert 0 < ended.infeasible_windows < ended.windows
    told = f"The calibration lacks {ended.infeasible_windows} of {ended.windows} windows"
    for text in (capsys.readouterr().out, (tmp_path / "report.md").read_text()):
        assert told in " ".join(text.split())


@pytest.mark.slow
def test_a_fit_that_has_too_few_steps_is_told_not_to_have_converged(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    hasty = {"solver": solver_settings(iterations=1, restarts=0)}
    report = fit(short_comparison(pendulum(), measured(logs()[:1], logs()[1:]), **hasty), look(), tmp_path)
    assert report.ladder[0].fit is not None
    assert not report.ladder[0].fit.converged
    for text in (capsys.readouterr().out, (tmp_path / "report.md").read_text()):
        assert "The calibration did not converge in 1 step:" in " ".join(text.split())


@pytest.mark.slow
def test_a_parameter_that_ends_at_its_bound_is_marked_on_the_screen(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    heavy = [swinging(f"log_{k}", pendulum().compile(np.array([1.9, 0.08])), k, seconds=1.5) for k in range(2)]
    report = fitted(pendulum(), measured(heavy[:1], heavy[1:]), tmp_path)
    at_bound = {name: row.at_bound for name, row in report.ladder[0].parameters.items()}
    assert at_bound == {"rod.mass": True, "hinge.damping": False}
    assert re.search(r"rod\.mass .* 1\.5 kg, at its bound", capsys.readouterr().out)


def test_a_model_that_diverges_says_so_before_any_fit(tmp_path: Path) -> None:
    explicit = """<mujoco model="stiff"><option timestep="0.01" integrator="Euler"><flag eulerdamp="disable"/></option>
      <worldbody><body><inertial mass="0.5" pos="0 0 -0.3" diaginertia="0.005 0.005 0.001"/>
      <joint name="hinge" axis="0 1 0" damping="40"/></body></worldbody>
      <actuator><motor name="drive" joint="hinge"/></actuator></mujoco>"""
    with pytest.raises(ModelError, match="diverges in every window"):
        fitted(model_of(explicit), measured(logs()), tmp_path)
