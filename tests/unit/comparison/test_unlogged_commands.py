"""Commands that were logged more slowly than sent are read as lines where that explains the motion better."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from dr_lab.comparison.comparison import Comparison
from dr_lab.comparison.notes import study_notes
from dr_lab.comparison.study import prepare
from dr_lab.comparison.unlogged_commands import longest_wait, with_lines
from dr_lab.diagnosis.faults.data_faults import Fault
from dr_lab.trajectory import Array, Log, Signal
from tests.diagnosis_machines import (
    PENDULUM,
    PENDULUM_PARAMETERS,
    STEP,
    clock,
    log_of,
    measured,
    model_of,
    pendulum,
    short_comparison,
    simulated,
)

WAIT = 0.04  # s
FAULTS = tuple(Fault("decimated", f"log_{k}", "drive", 0.0, 4.0, "", "") for k in (1, 2))


def log(seed: int, sent: Callable[[Array], Array], between: str) -> Log:
    """A pendulum under a command at 250 Hz, of which every tenth is logged."""
    time, rng = clock(1000, 0.004), np.random.default_rng(seed)
    waves = 0.6 * np.sin(9 * time + rng.uniform(0, 6)) + 0.5 * np.sin(25 * time + rng.uniform(0, 6))
    command = Signal("drive", "N·m", time, sent(waves))
    motion = simulated(pendulum().compile(np.array([0.6, 0.08])), command, 4.0, qpos=[0.5])
    reading = motion["qpos"][:, 0] + 5e-4 * rng.standard_normal(len(motion["time"]))
    logged = replace(command, time=time[::10], value=command.value[::10], between=between)
    return log_of(f"log_{seed}", {"hinge.position": (motion["time"][::5], reading[::5])}, logged)


def as_sent(waves: Array) -> Array:
    return waves


def held(waves: Array) -> Array:
    """As if only every tenth had been sent."""
    return np.repeat(waves[::10], 10)


def weak(waves: Array) -> Array:
    return 1e-4 * waves


def restless(waves: Array) -> Array:
    """As if most of what is sent changed three times between two logged samples."""
    return waves + 2.0 * np.sin(112.0 * clock(1000, 0.004))


@cache
def comparison(sent: Callable[[Array], Array] = as_sent, between: str = "") -> Comparison:
    one, other = (log(seed, sent, between) for seed in (1, 2))
    return short_comparison(pendulum(), measured([one], [other], noise=5e-4))


def between(found: Comparison) -> list[str]:
    logs = (*found.measurements.fit, *found.measurements.held_out)
    return [each.commands["drive"].between for each in logs]


def test_lines_that_explain_more_are_taken_and_told() -> None:
    found = with_lines(comparison(), FAULTS, ())
    assert between(found) == ["unknown", "unknown"]
    for each in (*found.measurements.fit, *found.measurements.held_out):
        (note,) = each.notes
        assert (note.kind, note.signal) == ("unlogged", "drive")
        assert "40 ms apart" in note.message
        assert "on the held-out logs" in note.message
        assert "measurements.commands.drive.between=hold" in note.message


def test_the_rarest_samples_say_which_shift_is_not_told() -> None:
    rare = comparison()
    logs = rare.measurements.fit[0], rare.measurements.held_out[0]
    sent = logs[0].commands["drive"]
    often = np.arange(sent.time[0], sent.time[-1], 0.004)
    dense = replace(sent, time=often, value=np.interp(often, sent.time, sent.value))
    mixed = replace(rare.measurements, fit=(replace(logs[0], commands={"drive": dense}),))
    (note,) = with_lines(replace(rare, measurements=mixed), FAULTS, ()).measurements.fit[0].notes
    assert "40 ms apart" in note.message
    assert "below 40 ms" in note.message


def test_lines_in_doubt_are_taken_where_a_fault_says_so_too() -> None:
    """Lines leave less, but what was sent beside them scatters that."""
    asked = comparison(restless)
    evidence = replace(asked.settings.evidence, confidence=1.0 - 1e-9)
    doubtful = replace(asked, settings=replace(asked.settings, evidence=evidence))
    assert between(with_lines(doubtful, FAULTS, ())) == ["unknown", "unknown"]
    assert between(with_lines(doubtful, (), ["drive"])) == ["", ""]


def test_commands_that_held_stay_held_whatever_is_suspected() -> None:
    assert with_lines(comparison(held), FAULTS, ()) is comparison(held)


def test_without_a_suspicion_nothing_is_tried() -> None:
    assert with_lines(comparison(), (), ()) is comparison()


@pytest.mark.parametrize("said", ["hold", "line", "unknown"])
def test_what_the_measurements_say_stands(said: str) -> None:
    assert with_lines(comparison(between=said), FAULTS, ()) is comparison(between=said)


@pytest.mark.parametrize(("said", "faults", "wait"), [("", FAULTS, WAIT), ("unknown", (), WAIT), ("line", (), 0.0)])
def test_no_shift_below_the_wait_between_logged_commands_can_be_told(
    said: str, faults: tuple[Fault, ...], wait: float
) -> None:
    assert longest_wait(comparison(between=said).measurements, faults) == pytest.approx(wait)


def test_what_a_study_finds_by_itself_stands_once_in_its_notes() -> None:
    study = prepare(comparison())
    assert {fault.kind for fault in study.faults} == {"decimated"}
    assert study.bench.fit.unlogged is not None
    assert study.bench.timing_resolution == pytest.approx(WAIT)
    (note,) = [note for note in study_notes(study) if note.kind == "unlogged"]
    assert note.log is None
    assert note.signal == "drive"


def test_of_commands_that_hold_the_step_alone_bounds_what_is_told() -> None:
    study = prepare(comparison(held))
    assert not study.faults
    assert study.bench.fit.unlogged is None
    assert study.bench.timing_resolution == pytest.approx(STEP)


def with_rotor(seed: int) -> Log:
    """A pendulum whose rotor weighs more than half as much as it, under a command of which every fifth is logged."""
    time, rng = clock(2000), np.random.default_rng(seed)
    sent = 0.6 * np.sin(6 * time + rng.uniform(0, 6)) + 0.4 * np.sin(15 * time + rng.uniform(0, 6))
    machine, command = pendulum().nominal(), Signal("drive", "N·m", time, sent)
    machine.dof_armature[0] = 0.03
    motion = simulated(machine, command, 4.0, qpos=[0.5])
    reading = motion["qpos"][:, 0] + 5e-4 * rng.standard_normal(len(motion["time"]))
    logged = replace(command, time=time[::5], value=sent[::5])
    return log_of(f"log_{seed}", {"hinge.position": (motion["time"][::2], reading[::2])}, logged)


@cache
def without_rotor() -> Comparison:
    """The same pendulum as a model that knows neither its rotor nor may change its mass."""
    model = model_of(PENDULUM, {"hinge.damping": PENDULUM_PARAMETERS["hinge.damping"]})
    return short_comparison(model, measured([with_rotor(1)], [with_rotor(2)], noise=5e-4))


def test_a_rotor_that_the_model_lacks_does_not_pass_for_commands_that_hold() -> None:
    asked = without_rotor()
    assert between(with_lines(asked, (), ["drive"])) == ["line", "line"]
    alone = replace(asked, settings=replace(asked.settings, usual={}))
    assert between(with_lines(alone, (), ["drive"])) == ["", ""]


def test_where_the_logs_do_not_tell_commands_are_held_but_no_shift_below_the_wait_is_told() -> None:
    """A command that hardly acts: both readings leave noise."""
    quiet = comparison(weak)
    found = with_lines(quiet, (), ["drive"])
    assert between(found) == ["", ""]
    (note,) = found.measurements.fit[0].notes
    assert (note.kind, note.signal) == ("undecided", "drive")
    assert "40 ms apart" in note.message
    assert longest_wait(found.measurements, ()) == pytest.approx(WAIT)


def test_lines_that_were_found_bound_the_shift_that_can_be_told() -> None:
    found = with_lines(without_rotor(), (), ["drive"])
    assert longest_wait(found.measurements, ()) == pytest.approx(0.01)
    (note,) = found.measurements.fit[0].notes
    assert "rotor inertia and dry friction" in note.message
    assert "estimated in every window" not in note.message
