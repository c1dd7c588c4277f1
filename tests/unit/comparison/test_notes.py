"""Notes of a report: what the data contract said of logs."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import cast

import pytest
from diagnosis_machines import (
    PENDULUM,
    evidence_settings,
    measured,
    model_of,
    pendulum,
    short_comparison,
    solver_settings,
    swinging,
    windows_of,
)
from effect_machines import placed

from dr_lab.comparison.calibrated import calibrated
from dr_lab.comparison.notes import disagreeing_logs, fit_notes, moved_bounds, study_notes
from dr_lab.comparison.silent_notes import silent_markdown
from dr_lab.comparison.study import Study, prepare
from dr_lab.diagnosis.evidence.bench import Bench, fit_and_score
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.trajectory import Note

LOST = Note("nan", "hinge.position", "hinge.position: 3 of 90 samples were dropped.", 3)


@cache
def study() -> Study:
    logs = [swinging(f"log_{k}", pendulum().nominal(), k) for k in range(2)]
    return prepare(short_comparison(pendulum(), measured(logs[:1], logs[1:])))


def told(first: tuple[Note, ...], second: tuple[Note, ...]) -> list[NoteEntry]:
    """The notes on samples that were lost, where these are the notes of two logs."""
    one, other = study().measurements.fit[0], study().measurements.held_out[0]
    noted = replace(study().measurements, fit=(replace(one, notes=first),), held_out=(replace(other, notes=second),))
    return [
        note
        for note in study_notes(replace(study(), comparison=replace(study().comparison, measurements=noted)))
        if note.kind == LOST.kind
    ]


def test_what_is_said_of_every_log_is_said_once_and_as_of_each() -> None:
    (note,) = told((LOST,), (LOST,))
    assert (note.log, note.count) == (None, 6)
    assert note.message == f"{LOST.message} The same in each of the logs."


def test_what_is_said_twice_of_one_log_is_no_matter_of_every_log() -> None:
    assert [note.log for note in told((LOST, LOST), ())] == ["log_0", "log_0"]


def test_a_note_that_counts_nothing_keeps_its_words() -> None:
    derived = Note(LOST.kind, "hinge.velocity", "It is made of the position.")
    (note,) = told((derived,), (derived,))
    assert (note.log, note.message) == (None, derived.message)


@pytest.mark.parametrize(
    ("over", "told", "remedy"),
    [
        (False, "The calibration did not converge in 3 steps: its parameters may not be", "Raise solver.iterations"),
        (True, "The calibration ended after 3 steps without a certificate", "more would not help"),
    ],
)
def test_a_fit_without_its_certificate_is_told_with_what_helps(told: str, remedy: str, *, over: bool) -> None:
    fitted_model = calibrated(study())
    ended = replace(fitted_model.fit, converged=False, over=over, iterations=3)
    (note,) = fit_notes([replace(fitted_model, fit=ended)])
    assert note.kind == "not_converged"
    assert note.message.startswith(told)
    assert remedy in note.message


def test_nothing_is_told_of_a_learned_force_whose_fit_took_no_step() -> None:
    fitted_model = calibrated(study())
    regressed = replace(fitted_model.fit, converged=False, iterations=0)
    assert not fit_notes([replace(fitted_model, fit=regressed)])


def test_a_log_without_room_for_a_window_is_told() -> None:
    logs = [swinging(f"log_{k}", pendulum().nominal(), k, seconds=0.25 if k == 1 else 3.0) for k in range(3)]
    notes = study_notes(prepare(short_comparison(pendulum(), measured(logs[:2], logs[2:]))))
    (note,) = [note for note in notes if note.kind == "no_window"]
    assert note.message.startswith("log_1 took no part: a window of 0.34 s without a gap")
    assert not [note for note in study_notes(study()) if note.kind == "no_window"]


@pytest.mark.parametrize("commanded", [True, False])
def test_an_actuator_without_a_command_is_told_before_anything_is_fitted(*, commanded: bool) -> None:
    log = swinging("log_0", pendulum().nominal(), 0)
    notes: list[NoteEntry] = []
    prepare(short_comparison(pendulum(), measured([log if commanded else replace(log, commands={})], [])), notes.extend)
    told = silent_markdown(notes)
    assert told.startswith("- No command is measured for drive: simulated with the control 0.") != commanded
    assert (told == "") == commanded


def test_logs_that_are_too_short_to_check_their_commands_are_told_before_anything_is_fitted() -> None:
    """16 test functions of 0.2 s, 0.05 s apart, need 0.95 s."""
    logs = [swinging(name, pendulum().nominal(), 0, seconds=s) for name, s in (("a", 3.0), ("b", 0.8), ("c", 3.0))]
    notes: list[NoteEntry] = []
    prepare(short_comparison(pendulum(), measured(logs[:2], logs[2:])), notes.extend)
    told = silent_markdown(notes)
    assert told.startswith(
        "- Too short to check whether commands have the right sign, unit and clock (less than 0.95 s)"
    )
    assert told.endswith(": b. What is wrong there would pass for physics.")


@pytest.mark.parametrize(("high", "told"), [(0.04, 1), (1.0, 0)])
def test_a_declared_bound_that_binds_is_told(high: float, told: int) -> None:
    """The machine's damping is 0.05 N·m·s/rad."""
    damping = {"hinge.damping": {"target": "joint.hinge.damping", "unit": "N·m·s/rad", "low": 0.0, "high": high}}
    model = model_of(PENDULUM.replace('damping="0.05"', 'damping="0.02"'), damping)
    logs = [swinging(f"log_{k}", model_of(PENDULUM, {}).nominal(), k) for k in range(2)]
    windows = windows_of(model, logs)
    bench = Bench(windows, windows, solver_settings(), evidence_settings(), 1)
    notes = fit_notes([fit_and_score(bench, model, model.space.nominal)])
    assert len(notes) == told
    for note in notes:
        assert "hinge.damping ends at its upper bound, 0.04 N·m·s/rad" in note.message
        assert "the logs ask for more" in note.message


@pytest.mark.parametrize(("worn", "count"), [(0.25, 1), (0.07, 0), (0.05, 0)])
def test_logs_that_do_not_agree_on_a_parameter_are_told(worn: float, count: int) -> None:
    damping = {"hinge.damping": {"target": "joint.hinge.damping", "unit": "N·m·s/rad", "low": 0.0, "high": 1.0}}
    model = model_of(PENDULUM, damping)
    other = model_of(PENDULUM.replace('damping="0.05"', f'damping="{worn}"'), damping)
    logs = [swinging("log_new", model.nominal(), 0), swinging("log_worn", other.nominal(), 1)]
    windows = windows_of(model, logs)
    bench = Bench(windows, windows, solver_settings(), evidence_settings(), 1)
    notes = disagreeing_logs(bench, fit_and_score(bench, model, model.space.nominal))
    assert len(notes) == count
    for note in notes:
        assert "hinge.damping: log_new asks for 0.0" in note.message
        assert "and log_worn asks for 0.2" in note.message


def test_a_moved_bound_and_where_the_added_effect_ended_have_their_unit() -> None:
    lag = "actuator_lag@drive.tau"
    wide = replace(placed(pendulum(), "actuator_lag", "drive"), looked=((lag, 0.0, 0.012),))
    alone, last = SimpleNamespace(values=lambda: {lag: 0.013}), SimpleNamespace(values=lambda: {lag: 0.005})
    rung = SimpleNamespace(ranking=[SimpleNamespace(effect=wide, fitted=True, fitted_model=alone)])
    ladder = SimpleNamespace(rungs=[rung], models=[last], steps=[])
    (note,) = moved_bounds(cast("Ladder", ladder))
    assert "(0 to 0.012 s)" in note.message
    assert note.message.endswith("s; the fit ended at 0.005 s.")


def test_a_moved_bound_of_a_pure_number_has_no_unit() -> None:
    excess = "sensor_scale@hinge.excess"
    wide = replace(placed(pendulum(), "sensor_scale", "hinge"), looked=((excess, -0.2, 0.2),))
    last = SimpleNamespace(values=lambda: {excess: 0.4166})
    rung = SimpleNamespace(ranking=[SimpleNamespace(effect=wide, fitted=True, fitted_model=last)])
    (note,) = moved_bounds(cast("Ladder", SimpleNamespace(rungs=[rung], models=[last], steps=[])))
    assert "(-0.2 to 0.2), which" in note.message
    assert note.message.endswith("the fit ended at 0.4166.")
