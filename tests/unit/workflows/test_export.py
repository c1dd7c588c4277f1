"""A policy is exported, and a control loop acts as it did."""

import csv
import json
from pathlib import Path

import numpy as np
import onnxruntime
import pytest
from test_train import OVERRIDES

import dr_lab
from dr_lab.__main__ import main
from dr_lab.cli.compose import compose_from
from dr_lab.cli.folders import shipped
from dr_lab.cli.job import Job, run_job
from dr_lab.errors import ConfigError, DataError
from dr_lab.reports.json_file import typed
from dr_lab.reports.policy import PolicyReport
from dr_lab.trajectory import Array

TRAIN = [*OVERRIDES, "env=furuta", "frames=320", "randomizer=fixed"]


def train(folder: Path, *overrides: str) -> Path:
    typed = [*TRAIN, *overrides]
    run_job(Job("train", tuple(typed), "run", folder, (shipped(),)), compose_from((shipped(),), "train", typed))
    return folder


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return train(tmp_path_factory.mktemp("runs") / "train")


@pytest.fixture(scope="module")
def exported(run: Path) -> Path:
    folder = run.parent / "export"
    assert main(["export", f"run={run}", f"hydra.run.dir={folder}", "onnx.episodes=2", "threads=1"]) == 0
    return folder


def read(folder: Path) -> PolicyReport:
    path = folder / "policy.json"
    return typed(PolicyReport, json.loads(path.read_text(encoding="utf-8")), path)


def course(folder: Path) -> dict[str, Array]:
    with (folder / "episode.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def numbered(columns: dict[str, Array], what: str) -> Array:
    return np.stack([value for name, value in columns.items() if name.startswith(f"{what}_")], axis=1)


def test_inputs_and_outputs_are_told(exported: Path) -> None:
    report = read(exported)
    angles = ["sin(arm position)", "cos(arm position)", "sin(pole position)", "cos(pole position)"]
    assert [each.name for each in report.inputs] == [*angles, "arm velocity [rad/s]", "pole velocity [rad/s]"]
    assert [(each.name, each.low, each.high) for each in report.outputs] == [("motor", -4.0, 4.0)]
    assert (report.env, report.seconds, report.notes) == ("furuta", 0.01, ())


def test_the_file_acts_as_the_episode_did(exported: Path) -> None:
    columns = course(exported)
    session = onnxruntime.InferenceSession(exported / "policy.onnx", providers=["CPUExecutionProvider"])
    seen, done = numbered(columns, "observation").astype(np.float32), numbered(columns, "action")
    assert (seen.shape, done.shape) == ((20, 6), (20, 1))
    for observation, action in zip(seen, done, strict=True):
        (found,) = session.run(None, {"observation": observation[None]})
        assert np.asarray(found) == pytest.approx(action[None], abs=1e-6)


def test_a_control_loop_acts_as_the_episode_did(run: Path, exported: Path) -> None:
    controller, columns = dr_lab.load_controller(run), course(exported)
    positions, velocities = (
        np.stack([columns[f"{name} [{unit}]"] for name, unit in each], axis=1)
        for each in (controller.positions, controller.velocities)
    )
    found = [controller.act(*state) for state in zip(positions, velocities, strict=True)]
    assert np.array(found) == pytest.approx(numbered(columns, "action"), abs=1e-6)
    assert (controller.seconds, controller.actuators) == (0.01, ("motor",))


@pytest.mark.parametrize("state", [[0.0], [0.0, np.nan]])
def test_a_control_loop_refuses_a_state_of_another_machine(run: Path, state: list[float]) -> None:
    with pytest.raises(DataError, match=r"qpos is .* expected 2 finite numbers: arm position in rad, pole position in"):
        dr_lab.load_controller(run).act(np.array(state), np.zeros(2))


def test_a_context_that_the_policy_sees_is_told(tmp_path: Path) -> None:
    seeing, folder = train(tmp_path / "seeing", "env.show_context=true"), tmp_path / "export"
    assert main(["export", f"run={seeing}", f"hydra.run.dir={folder}", "onnx.episodes=1", "threads=1"]) == 0
    report = read(folder)
    shown = len(report.inputs) - 6
    assert shown > 0
    assert all("value in" in (each.name or "") for each in report.inputs[6:])
    assert report.notes == (
        f"The last {shown} inputs tell the policy what the machine is like, as shares of the bounds.",
    )


def test_a_policy_that_is_made_to_be_adapted_is_told_as_such(tmp_path: Path) -> None:
    maml = [
        "algorithm=maml",
        "algorithm.tasks=2",
        "env=nav2d",
        "frames=400",
        "episodes=8",
        "algorithm.batch_frames=160",
    ]
    maml = [*maml, "env.task.time_limit=10", "threads=1"]
    folder = tmp_path / "train"
    assert main(["train", *maml, f"hydra.run.dir={folder}"]) == 0
    assert main(["export", f"run={folder}", f"hydra.run.dir={tmp_path / 'export'}", "onnx.episodes=1"]) == 0
    report = read(tmp_path / "export")
    assert report.notes == ("It is the policy that every adaptation begins with, adapted to nothing yet.",)
    assert [each.name for each in report.inputs] == ["x position [m]", "y position [m]"]
    with pytest.raises(ConfigError, match=r"env=nav2d has none\. Make them yourself"):
        dr_lab.load_controller(folder)


@pytest.mark.slow
def test_inputs_of_another_engine_that_have_no_name_are_told_as_well(tmp_path: Path) -> None:
    short = [word for word in TRAIN if not word.startswith(("env=", "env."))]
    folder = tmp_path / "train"
    assert main(["train", *short, "env=lunar_lander", f"hydra.run.dir={folder}"]) == 0
    assert main(["export", f"run={folder}", f"hydra.run.dir={tmp_path / 'export'}", "onnx.episodes=1"]) == 0
    report = read(tmp_path / "export")
    assert report.inputs[0].name is None
    assert report.notes[0].startswith(
        "Inputs 0, 1, 2, 3, 5, 6, 7 are no single position or velocity. They are those of"
    )


def test_nothing_is_left_where_the_run_is_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "export"
    assert main(["export", f"run={tmp_path}", f"hydra.run.dir={folder}"]) == 2
    assert "holds no checkpoint.pt" in capsys.readouterr().err
    assert not (folder / "policy.onnx").exists()


def test_a_file_that_acts_otherwise_is_not_written(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "export"
    assert main(["export", f"run={run}", f"hydra.run.dir={folder}", "onnx.tolerance=1e-12", "threads=1"]) == 2
    assert "acts otherwise than the policy" in capsys.readouterr().err
    assert not (folder / "policy.onnx").exists()
    assert not (folder / "policy.json").exists()
