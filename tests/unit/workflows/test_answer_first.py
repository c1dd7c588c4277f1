"""What a verb prints while it works comes in the order in which its user needs it, and nothing is fitted twice."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagnosis_machines import (
    localise_settings,
    measured,
    pendulum,
    short_comparison,
    swinging,
)
from effect_machines import catalogue_effect
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.comparison import finish, ladder_report, state_fits
from dr_lab.comparison.state_fits import StateFits
from dr_lab.comparison.study import prepare
from dr_lab.trajectory import MeasurementSet
from dr_lab.workflows.add import add
from dr_lab.workflows.diagnose import diagnose

TRUTH = np.array([0.6, 0.08])


def data() -> MeasurementSet:
    logs = [swinging(f"log_{k}", pendulum().compile(TRUTH), k, seconds=2.0) for k in range(2)]
    return measured(logs[:1], logs[1:])


def test_the_answer_is_out_before_the_recordings_begin(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    known = ""

    def write_review(*_: object) -> None:
        nonlocal known
        known = capsys.readouterr().out

    monkeypatch.setattr(finish, "write_review", write_review)
    recorder = instantiate(compose("fit", []).recorder)
    effects = {"coulomb_friction": catalogue_effect("coulomb_friction")}
    add(short_comparison(pendulum(), data()), effects, {"joint": "hinge"}, recorder, tmp_path)
    places = [
        known.index(text)
        for text in (
            "Cutting the logs into windows …",
            "Calibrating the model …",
            "Trying coulomb_friction@hinge …",
            "Scoring the models of the ladder …",
            "No missing effect:",
            "value ± std",
            "Looking where the model fails and what it misses …",
            "Writing the report …",
            "Writing the recordings …",
        )
    ]
    assert places == sorted(places)
    assert (tmp_path / "report.json").is_file()


def test_states_are_fitted_once_and_those_of_some_windows_are_among_those_of_all(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model = pendulum()
    study = prepare(short_comparison(model, data()))
    count, few = 0, study.few[::2]

    def counted(*arguments: Any) -> Any:  # noqa: ANN401 (whatever it is)
        nonlocal count
        count += 1
        return fit_roughly(*arguments)

    fit_roughly = state_fits.fit_roughly
    monkeypatch.setattr(state_fits, "fit_roughly", counted)
    fits, alone = (StateFits(study.bench.solver, 1) for _ in range(2))
    replay, every, tape = fits.rough(model, TRUTH, study.short)
    assert fits.rough(model, TRUTH, study.short)[1] is every
    among = fits.forces(model, TRUTH, study.short, few)["hinge"]
    assert count == 1
    np.testing.assert_array_equal(among.velocity, tape.qvel[0][few].mean(1)[:, 0])
    fits.rough(model, TRUTH + 0.01, study.short)
    assert count == 2
    again = alone.forces(model, TRUTH, study.short, few)["hinge"].force
    np.testing.assert_allclose(among.force, again, atol=1e-4 * float(np.abs(again).max()))
    assert len(replay.windows) == len(study.short)
    assert len(among.force) == len(study.short.pick(few)) == len(few)


def test_few_windows_are_spread_over_all() -> None:
    study = prepare(short_comparison(pendulum(), data()))
    assert len(study.few) == len(study.short)  # as many as there are
    default = localise_settings()
    sparse = replace(default, formula=replace(default.formula, windows=5))
    study = prepare(short_comparison(pendulum(), data(), localise=sparse))
    assert len(study.few) == 5
    assert (study.few[0], study.few[-1]) == (0, len(study.short) - 1)
    assert np.ptp(np.diff(study.few)) <= 1


def test_the_report_is_there_before_the_next_experiment_is_looked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def pressed(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(ladder_report, "deciding_experiment", pressed)
    cfg = compose("diagnose", [])
    effects = {"coulomb_friction": catalogue_effect("coulomb_friction")}
    comparison, experiments = short_comparison(pendulum(), data()), instantiate(cfg.next_experiment)
    with pytest.raises(KeyboardInterrupt):
        diagnose(comparison, effects, experiments, instantiate(cfg.recorder), tmp_path)
    assert json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["verdict"] == "none"
    assert "No missing effect" in (tmp_path / "report.md").read_text(encoding="utf-8")
