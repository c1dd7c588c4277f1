from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from diagnosis_machines import experiment_settings, measured, pendulum, short_comparison, swinging

from dr_lab.comparison.calibrated import calibrate
from dr_lab.comparison.deciding import deciding_experiment
from dr_lab.comparison.experiment_machine import experiment_machine
from dr_lab.comparison.study import Study, prepare
from dr_lab.diagnosis.next_experiment.settings import ExperimentSettings
from dr_lab.diagnosis.search.ladder import Ladder

WEIGHT = 0.5 * 9.81 * 0.3  # N·m of the rod, horizontal


@cache
def study() -> Study:
    """A pendulum that begins its logs at 0.8 rad, under torques of up to 1 N·m that change ten times a second."""
    logs = [swinging(f"log_{k}", pendulum().nominal(), k) for k in range(3)]
    return prepare(short_comparison(pendulum(), measured(logs[:2], logs[2:])))


@cache
def ladder() -> Ladder:
    return Ladder((), calibrate(study()), ())


def settings(**changes: object) -> ExperimentSettings:
    small = {"population": 6, "generations": 1, "refitted": 1, "durations": [2.0], **changes}
    return experiment_settings(**small)


def commands(folder: Path) -> Mapping[str, np.ndarray]:
    with (folder / "next_experiment.csv").open(encoding="utf-8") as file:
        names = file.readline().strip().split(",")
        return dict(zip(names, np.loadtxt(file, delimiter=",").T, strict=True))


def test_the_machine_starts_as_its_logs_do_and_keeps_what_they_show() -> None:
    found = experiment_machine(study(), ladder().base, settings())
    assert found is not None
    machine, at_rest = found
    assert machine.start[0] == pytest.approx(0.8, abs=0.01)
    assert abs(at_rest.hold["drive"]) == pytest.approx(WEIGHT * np.sin(0.8), rel=0.05)
    assert (machine.bounds.low[0], machine.bounds.high[0]) == pytest.approx((-1.2, 1.2), abs=0.02)
    assert machine.command_rate == pytest.approx(10.0)
    values = np.concatenate([log.outputs["hinge.position"].value for log in study().measurements.fit])
    assert machine.kept.high[0] < values.max() + 0.2 * np.ptp(values)
    assert machine.kept.low[0] > values.min() - 0.2 * np.ptp(values)


def test_a_log_that_swings_freely_slows_no_experiment_down() -> None:
    logs = [swinging(f"log_{k}", pendulum().nominal(), k) for k in range(2)]
    off = replace(logs[1].commands["drive"], time=np.array([0.0, 3.0]), value=np.zeros(2))
    free = prepare(short_comparison(pendulum(), measured([logs[0], replace(logs[1], commands={"drive": off})])))
    found = experiment_machine(free, calibrate(free), settings())
    assert found is not None
    assert found[0].command_rate == pytest.approx(10.0)


def test_what_is_poorly_known_is_offered_an_experiment(tmp_path: Path) -> None:
    entry = deciding_experiment(study(), ladder(), settings(poor=1e-6), tmp_path)
    assert entry is not None
    assert {row.parameter for row in entry.sharpens} == {"rod.mass", "hinge.damping"}
    assert all(row.std is not None and row.std_after is not None and row.std_after < row.std for row in entry.sharpens)
    played = commands(tmp_path)
    assert list(played) == ["time_s", "drive"]
    assert played["time_s"][-1] == pytest.approx(2.0)
    np.testing.assert_allclose(played["drive"][[0, -1]], entry.hold["drive"], rtol=1e-6)
    assert entry.start["hinge.position"] == pytest.approx(0.8, abs=0.01)
    assert entry.taken is not None
    assert entry.taken <= 1


def test_nothing_is_offered_where_nothing_is_to_be_told(tmp_path: Path) -> None:
    assert deciding_experiment(study(), ladder(), settings(poor=1e3), tmp_path) is None
    assert not (tmp_path / "next_experiment.csv").exists()


def test_where_no_experiment_keeps_the_limits_the_report_says_which(tmp_path: Path) -> None:
    """The machine has shown no motion at all that a reserve of most of it leaves free."""
    tight = settings(poor=1e-6)
    tight = replace(tight, safety=replace(tight.safety, margin=0.0, reserve=0.8999, spread=200.0))
    entry = deciding_experiment(study(), ladder(), tight, tmp_path)
    assert entry is not None
    assert entry.reason
    assert entry.command_file == ""
