"""A proposed experiment, played on a plant: its commands, its pose, its place beside the other logs."""

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hydra.utils import instantiate

from dr_lab.__main__ import main
from dr_lab.cli.compose import compose
from dr_lab.errors import ConfigError, DataError
from dr_lab.plants.rig import RigRecording
from dr_lab.sources.next_experiment import NextExperimentSource

ON_TIME = ["plant/instruments=exact", "plant.instruments.command_rate=100.0"]


@pytest.fixture
def run(tmp_path: Path, close_report: dict[str, Any]) -> Path:
    folder = tmp_path / "closed"
    folder.mkdir()
    propose(folder, close_report, start={"arm.position": 0.5, "pole.position": -0.2}, duration=0.06)
    (folder / "next_experiment.csv").write_text("time_s,motor\n0,1.5\n0.02,-2\n0.04,0.25\n", "utf-8")
    return folder


def propose(folder: Path, report: dict[str, Any], **entry: object) -> None:
    report = copy.deepcopy(report)
    report["next_experiment"] |= entry
    (folder / "report.json").write_text(json.dumps(report), "utf-8")


def source(run: Path, *overrides: str) -> NextExperimentSource:
    composed = compose("record", ["source=next_experiment", f"run={run}", *ON_TIME, *overrides])
    return instantiate(composed.source, _convert_="all")


def recordings(played: NextExperimentSource, seed: int = 3) -> list[RigRecording]:
    return list(played.rig().recordings(seed))


def test_rows_are_sent_at_their_times_from_the_pose(run: Path) -> None:
    (log,) = recordings(source(run))
    assert log.name == "next_1"
    np.testing.assert_allclose(log.command[:, 0], [1.5, -2.0, -2.0, 0.25, 0.25])  # from 0.01 s on, every 0.01 s
    np.testing.assert_allclose(log.position[0], [0.5, -0.2], atol=1e-3)


def test_jitter_skips_no_row(run: Path) -> None:
    rows = [f"{0.01 * k:.2f},{0.01 * k:.2f}" for k in range(100)]
    (run / "next_experiment.csv").write_text("\n".join(["time_s,motor", *rows, ""]), "utf-8")
    propose(run, json.loads((run / "report.json").read_text("utf-8")), duration=1.0)
    (log,) = recordings(source(run, "plant/instruments=encoders"))
    np.testing.assert_allclose(log.command[:, 0], 0.01 * np.arange(1, 100), atol=1e-9)  # the first one held before


def test_the_machine_is_held_by_the_first_row(run: Path) -> None:
    """A constant command from the start on moves the machine as if it had always been there."""
    (run / "next_experiment.csv").write_text("time_s,motor\n0,3\n0.02,3\n", "utf-8")
    early, late = (
        recordings(source(run, f"plant.instruments.actuation_latency={latency}"))[0].position for latency in (0, 0.02)
    )
    np.testing.assert_allclose(early, late, atol=1e-9)


def test_logs_come_after_those_of_the_bench_with_noise_of_their_own(run: Path) -> None:
    noisy = ["plant/instruments=encoders", "repeats=2"]
    first, second = recordings(source(run, *noisy))
    bench = instantiate(compose("record", noisy[:1]).plant, _convert_="all")
    assert first.command_time[0] > bench.epoch + (len(bench.peaks) - 0.5) * bench.pause
    assert second.command_time[0] > first.command_time[-1]
    assert np.ptp(first.command_time - second.command_time) > 0  # jitter


def test_logs_join_the_folder_of_the_others(run: Path, tmp_path: Path) -> None:
    logs = tmp_path / "logs"
    short = ["plant.duration=0.2", "plant.peaks=[6.0]", f"output={logs}", f"outputs={tmp_path / 'outputs'}"]
    assert main(["record", *short]) == 0
    assert main(["record", "source=next_experiment", f"run={run}", *short[2:]]) == 0
    assert sorted(path.name for path in logs.iterdir()) == ["log_1.mcap", "next_1.mcap", "truth.yaml"]


@pytest.mark.parametrize(
    "lines",
    [
        "",
        "time_s,motor\n",
        "time_s,motor\n0,1.5\n0.02\n",
        "time_s,motor\n0,1.5,7\n",
        "time_s,motor\n0,off\n",
        "time_s,motor\n0,nan\n",
        "time_s,motor\n0.02,1\n0,2\n",
    ],
)
def test_a_file_that_was_spoilt_is_told(run: Path, lines: str) -> None:
    (run / "next_experiment.csv").write_text(lines, "utf-8")
    with pytest.raises(DataError, match=r"holds no table .*; expected the line time_s,motor and .* times increase\."):
        recordings(source(run))


def test_blank_lines_count_nothing(run: Path) -> None:
    (run / "next_experiment.csv").write_text("time_s,motor\n0,1.5\n\n0.02,-2\n\n", "utf-8")
    (log,) = recordings(source(run))
    np.testing.assert_allclose(log.command[:, 0], [1.5, -2.0, -2.0, -2.0, -2.0])


def test_an_experiment_is_played_once_at_least(run: Path) -> None:
    with pytest.raises(Exception, match=r"repeats is 0; expected at least 1\."):
        source(run, "repeats=0")


def test_what_cannot_be_played_is_told(run: Path, tmp_path: Path, close_report: dict[str, Any]) -> None:
    with pytest.raises(ConfigError, match=r"holds no report\.json"):
        recordings(source(tmp_path))
    with pytest.raises(ConfigError, match=r"moves arm, pole; this machine has pendulum\. Give the plant"):
        recordings(source(run, "plant=pendulum"))
    (run / "next_experiment.csv").write_text("time_s,left,right\n0,1,1\n", "utf-8")
    with pytest.raises(ConfigError, match=r"commands left, right; this machine has motor"):
        recordings(source(run))
    (run / "next_experiment.csv").unlink()
    with pytest.raises(ConfigError, match=r"next_experiment\.csv, which is not there"):
        recordings(source(run))
    propose(run, close_report, reason="the range of arm")
    with pytest.raises(ConfigError, match=r"proposes no experiment.*the range of arm"):
        recordings(source(run))
    (run / "report.json").write_text(json.dumps({**close_report, "next_experiment": None}), "utf-8")
    with pytest.raises(ConfigError, match="nothing to separate"):
        recordings(source(run))
    (run / "report.json").write_text('{"schema": "dr_lab/train/1"}', "utf-8")
    with pytest.raises(ConfigError, match=r"run=.* holds a report of schema 'dr_lab/train/1'"):
        recordings(source(run))
    (run / "report.json").write_text("{broken", "utf-8")
    with pytest.raises(DataError, match=r"report\.json cannot be read"):
        recordings(source(run))
