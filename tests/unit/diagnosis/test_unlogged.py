"""Commands that changed without being logged: lines between samples, and what they miss as unknowns of the windows."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from dr_lab.diagnosis.evidence.score import Score, score_of
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.diagnosis.windows.commands import averages
from dr_lab.diagnosis.windows.unlogged import Unlogged, unlogged
from dr_lab.trajectory import Array, Log, Signal
from tests.diagnosis_machines import clock, log_of, pendulum, simulated, solver_settings, windows_of, windows_settings

STD = 2e-4  # rad
EDGES = clock(5, 0.05)  # s after a window's start


def test_straight_commands_enter_as_the_integral_of_their_line() -> None:
    signal = Signal("motor", "V", np.array([0.0, 0.02, 0.05]), np.array([1.0, 3.0, -3.0]), "line")
    edges = np.array([[-0.01, 0.0, 0.01, 0.03, 0.05, 0.07]])
    expected = [1.0, 1.5, (0.01 * 2.5 + 0.01 * 2.0) / 0.02, -1.0, -3.0]  # means of linear pieces
    np.testing.assert_allclose(averages({"motor": signal}, {"motor": 0}, 1, edges)[0, :, 0], expected, atol=1e-12)


def staircase(between: str) -> Log:
    """A log whose command is sent 0, 4, 4, 1 at 0, 0.1, 0.2, 0.3 s."""
    time = np.array([0.0, 0.1, 0.2, 0.3])
    return Log("a", {}, {"drive": Signal("drive", "N·m", time, np.array([0.0, 4.0, 4.0, 1.0]), between)})


def test_an_unknown_is_the_scatter_of_a_step_at_any_instant() -> None:
    found = unlogged([staircase("unknown")], [np.array([0.05])], {"drive": 1}, EDGES, 9)
    assert found is not None
    assert found.column.tolist() == [[1, 1, 1]]
    sizes = np.array([[4.0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 3.0]]) / np.sqrt(12)
    np.testing.assert_allclose(found.size[0], sizes, atol=1e-12)
    step = np.random.default_rng(0).uniform(0, 0.1, 100_000)  # the instant of a step by 4, its mean less that of a line
    assert np.std(4.0 * (0.1 - step) / 0.1 - 2.0) == pytest.approx(found.size[0, 0, 0], rel=0.01)


def test_the_largest_unknowns_are_taken() -> None:
    found = unlogged([staircase("unknown")], [np.array([0.05])], {"drive": 0}, EDGES, 1)
    assert found is not None
    assert found.size[0].sum() == pytest.approx(4 / np.sqrt(12))


@pytest.mark.parametrize("between", ["", "hold", "line"])
def test_commands_that_are_known_have_none(between: str) -> None:
    assert unlogged([staircase(between)], [np.array([0.05])], {"drive": 0}, EDGES, 9) is None


def test_unknowns_act_on_their_own_columns() -> None:
    known = Unlogged(np.array([[0, 1]]), np.array([[[1.0, 0.0], [0.5, 2.0]]]))
    found = known.added(np.full((1, 2, 2), 10.0), np.array([[[3.0, -1.0]], [[0.0, 0.0]]]))
    np.testing.assert_allclose(found, [[[[13.0, 9.5], [10.0, 8.0]]], [[[10.0, 10.0], [10.0, 10.0]]]])


def sent(seed: int) -> Signal:
    """Sines and steps at 250 Hz for 4 s."""
    time, rng = clock(1000, 0.004), np.random.default_rng(seed)
    waves = 0.5 * np.sin(9 * time + rng.uniform(0, 6)) + 0.3 * np.sin(17 * time + rng.uniform(0, 6))
    return Signal("drive", "N·m", time, waves + np.repeat(rng.uniform(-0.4, 0.4, 11), 97)[:1000])


@cache
def logs() -> tuple[Log, ...]:
    """Two logs of a pendulum of 0.65 kg, by encoders at 100 Hz, with every fifth command."""
    model = pendulum()
    compiled = model.compile(np.array([0.65, 0.08]))
    made = []
    for seed in (1, 2):
        command = sent(seed)
        motion = simulated(compiled, command, 4.0, qpos=[0.5])
        reading = motion["qpos"][:, 0] + STD * np.random.default_rng(seed).standard_normal(len(motion["time"]))
        fewer = replace(command, time=command.time[::5], value=command.value[::5])
        made.append(log_of(f"log_{seed}", {"hinge.position": (motion["time"][::5], reading[::5])}, fewer))
    return tuple(made)


def read_as(between: str) -> tuple[Array, Score]:
    """The pendulum fitted to the first log, and its score on the second."""
    one, other = (replace(log, commands={"drive": replace(log.commands["drive"], between=between)}) for log in logs())
    model, settings = pendulum(), windows_settings(seconds=2.4)
    fit = Fitter(Replay(model, windows_of(model, [one], settings, STD), 1), solver_settings()).run(model.space.nominal)
    held_out = windows_of(model, [other], settings, STD)
    return fit.z, score_of(*fit_states(model, fit.z, held_out, solver_settings(), 1))


def test_a_machine_is_known_from_every_fifth_command() -> None:
    (mass, damping), score = read_as("unknown")
    assert 0.8 < score.chi2 < 1.25  # 30 residuals a window, 8 windows: five standard deviations
    assert mass == pytest.approx(0.65, rel=0.05)
    assert damping == pytest.approx(0.08, abs=0.02)


def test_held_and_straight_commands_leave_far_more() -> None:
    held, straight = (read_as(between)[1].chi2 for between in ("hold", "line"))
    assert held > 2 * straight > 6
