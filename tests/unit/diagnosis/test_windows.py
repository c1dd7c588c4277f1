from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import STEP, clock, measured, model_of, pendulum, steps_command, windows_of, windows_settings

from dr_lab.diagnosis.windows.windows import Windows, cut
from dr_lab.errors import DataError
from dr_lab.trajectory import Array, Log, Note, Signal

TWO = """<mujoco model="two"><worldbody>
  <body name="a"><joint name="hinge" axis="0 1 0"/><geom size="0.1"/></body>
  <body name="b" pos="1 0 0"><joint name="other" axis="0 1 0"/><geom size="0.1"/></body>
</worldbody></mujoco>"""


def times(seconds: float = 5.0, rate: float = 500.0) -> Array:
    return clock(round(seconds * rate), 1 / rate)


def log(name: str, time: Array, command: Signal | None = None) -> Log:
    output = Signal("hinge.position", "rad", time, np.sin(time))
    return Log(name, {output.name: output}, {command.name: command} if command else {})


def spans(windows: Windows, total: float) -> list[tuple[float, float]]:
    return [(float(b), float(b) + total) for b in windows.begin]


def test_no_window_touches_a_gap() -> None:
    time = times()
    kept = time[(time < 1.0) | (time > 1.3)]
    settings = windows_settings(length=0.05, seconds=1000.0)
    windows = windows_of(pendulum(), [log("a", kept)], settings)
    total = settings.length + 2 * settings.margin
    assert all(end < 1.0 or begin > 1.3 for begin, end in spans(windows, total))
    assert windows.begin.min() < 0.1
    assert windows.begin.max() > 4.6
    assert ((windows.begin > 0.84) & (windows.begin < 0.91)).any()  # up to the gap


def test_no_window_touches_a_gap_of_a_command_or_comes_behind_its_end() -> None:
    time = times()
    sent = time[(time < 1.0) | ((time > 1.3) & (time < 4.0))]
    measured_log = log("a", time, Signal("drive", "N·m", sent, np.sin(sent)))
    settings = windows_settings(length=0.05, seconds=1000.0)
    found = replace(measured([measured_log]), gaps={"hinge.position": 0.1, "drive": 0.1})
    windows = cut([measured_log], found, pendulum().nominal(), settings)
    total = settings.length + 2 * settings.margin
    assert all(end < 1.0 or begin - settings.past > 1.3 for begin, end in spans(windows, total))
    assert 3.8 < windows.begin.max() + total < 4.1


def test_a_slow_rate_is_no_gap_but_a_dropout_in_it_is() -> None:
    slow = np.delete(clock(50, 0.09), [20, 21])
    windows = windows_of(pendulum(), [log("a", slow)], windows_settings(seconds=1000.0))
    assert len(windows) > 5
    assert not ((windows.begin < slow[20]) & (windows.begin + 0.34 > slow[19])).any()


def test_at_most_so_many_windows_evenly_spread() -> None:
    every = windows_of(pendulum(), [log("a", times())], windows_settings(seconds=1000.0))
    few = windows_of(pendulum(), [log("a", times())], windows_settings(seconds=1.2))
    assert len(every) == 16
    np.testing.assert_allclose(few.begin, every.begin[[0, 5, 10, 15]])


def test_samples_lie_between_the_margins_and_controls_cover_them() -> None:
    settings = windows_settings()
    windows = windows_of(pendulum(), [log("a", times())], settings)
    (samples,) = windows.samples
    used = samples.time[samples.scored]
    assert used.min() == pytest.approx(settings.margin)
    assert used.max() == pytest.approx(settings.margin + settings.length - STEP)
    assert windows.controls.shape[1] * STEP >= settings.length + 2 * settings.margin
    np.testing.assert_array_equal(samples.fitted, samples.scored)


def test_scored_parts_follow_one_another_without_overlap() -> None:
    time = times()
    windows = windows_of(pendulum(), [log("a", time)], windows_settings(seconds=1000.0))
    (samples,) = windows.samples
    stamps = (samples.time + windows.begin[:, None])[samples.scored]
    inside = (time >= stamps.min() - 1e-9) & (time <= stamps.max() + 1e-9)
    np.testing.assert_allclose(np.sort(stamps), time[inside], atol=1e-12)


def test_what_is_known_of_a_predicted_window_is_not_scored() -> None:
    settings = windows_settings(margin=0.021, run_in=0.098)  # between two samples
    (samples,) = windows_of(pendulum(), [log("a", times())], settings).samples
    assert not (samples.fitted & samples.scored).any()
    lead = settings.margin + settings.run_in
    assert samples.time[samples.fitted].max() < lead < samples.time[samples.scored].min()
    np.testing.assert_array_equal(samples.fitted.sum(1), 49)
    np.testing.assert_array_equal(samples.scored.sum(1), 150)


def test_samples_keep_their_own_times_and_values() -> None:
    time = np.sort(np.random.default_rng(0).uniform(0.0, 5.0, 1500))
    windows = windows_of(pendulum(), [log("a", time)])
    (samples,) = windows.samples
    stamps = samples.time + windows.begin[:, None]
    np.testing.assert_allclose(samples.value[samples.scored, 0], np.sin(stamps[samples.scored]), atol=1e-12)


def test_channels_at_different_rates_stand_side_by_side() -> None:
    fast, slow = times(), times(rate=40.0)
    outputs = {
        "hinge.position": Signal("hinge.position", "rad", fast, np.sin(fast)),
        "other.position": Signal("other.position", "rad", slow, np.cos(slow)),
    }
    one, two = windows_of(model_of(TWO), [Log("a", outputs, {})]).samples
    assert (one.scored.sum(1) == 150).all()
    assert (two.scored.sum(1) == 12).all()
    assert one.time.shape[1] == 150
    assert two.time.shape[1] == 12


def test_commands_before_a_window_are_known_and_kept() -> None:
    command = steps_command("drive", 2.0, 5.0, seed=0, period=0.01)
    settings = windows_settings()
    windows = windows_of(pendulum(), [log("a", times(), command)], settings)
    assert windows.begin.min() >= settings.past
    assert windows.past.shape[1] * STEP == pytest.approx(settings.kept)
    for controls, start in ((windows.past, -windows.past.shape[1]), (windows.controls, 0)):
        middle = windows.begin[:, None] + STEP * (start + 0.5 + np.arange(controls.shape[1]))
        issued = np.searchsorted(command.time, middle, side="right") - 1
        held = command.value[np.maximum(issued, 0)]  # before the first one it is what was asked
        np.testing.assert_allclose(controls[..., 0], held, atol=1e-9)


def test_logs_without_commands_have_none() -> None:
    windows = windows_of(pendulum(), [log("a", times())])
    assert not windows.controls.any()
    assert windows.commands == {}


def test_a_log_that_is_too_short_is_left_out() -> None:
    windows = windows_of(pendulum(), [log("a", times(0.3)), log("b", times()), log("c", times(0.2))])
    assert windows.logs == ("b",)
    np.testing.assert_array_equal(windows.log, 0)


def test_logs_that_are_all_too_short_are_an_error_with_their_lengths() -> None:
    with pytest.raises(DataError, match=r"No log holds one gapless window of 0\.34 s .*a 0\.298 s"):
        windows_of(pendulum(), [log("a", times(0.3))])


def test_logs_that_are_all_broken_by_gaps_say_so() -> None:
    broken = replace(log("a", np.concatenate([times(0.3), times(0.3) + 9.0])), notes=(Note("gap", "", "q: 1 gap."),))
    with pytest.raises(DataError, match=r"\(logs: a 9\.3 s\)\. In a q: 1 gap\. Shorten .* or some without gaps\."):
        windows_of(pendulum(), [broken])


def test_windows_between_the_samples_are_an_error() -> None:
    rare = measured([log("a", clock(20, 0.5))])
    with pytest.raises(DataError, match="Lengthen"):
        cut(
            rare.fit,
            replace(rare, gaps={"hinge.position": 1.0}),
            pendulum().nominal(),
            windows_settings(length=0.05, seconds=0.05),
        )


def test_samples_of_uneven_logs_are_those_between_the_windows_edges() -> None:
    rng = np.random.default_rng(5)
    stamps = [np.cumsum(rng.uniform(1e-3, 9e-3, 500)) + 3.0 * k for k in range(2)]
    settings = windows_settings(length=0.2, run_in=0.1)
    windows = windows_of(pendulum(), [log(f"log_{k}", t) for k, t in enumerate(stamps)], settings)
    (samples,) = windows.samples
    assert set(windows.log) == {0, 1}
    for k, (which, begin) in enumerate(zip(windows.log, windows.begin, strict=True)):
        time, middle = stamps[which], begin + settings.margin + settings.run_in
        known = (time >= begin + settings.margin) & (time < middle)
        scored = (time >= middle) & (time < middle + settings.length)
        for chosen, mask in ((known, samples.fitted), (scored, samples.scored)):
            np.testing.assert_allclose(samples.time[k, mask[k]], time[chosen] - begin, atol=1e-12)
            np.testing.assert_array_equal(samples.value[k, mask[k], 0], np.sin(time[chosen]))


def test_short_logs_leave_their_share_to_longer_ones() -> None:
    logs = [log("short", times(0.8)), log("long", times(6.0)), log("longer", times(9.0))]
    windows = windows_of(pendulum(), logs, windows_settings(seconds=6.6))
    assert np.bincount(windows.log).tolist() == [2, 10, 10]


def test_every_log_gives_a_window_however_few_seconds_are_asked_for() -> None:
    logs = [log(f"log_{k}", times(2.0)) for k in range(4)]
    assert np.bincount(windows_of(pendulum(), logs, windows_settings(seconds=0.3)).log).tolist() == [1, 1, 1, 1]


@pytest.mark.parametrize(
    ("longest", "lengths"), [(2.7, [0.3, 0.9, 2.7]), (2.0, [0.3, 0.9]), (0.3, [0.3]), (0.1, [0.3])]
)
def test_lengths_grow_up_to_the_longest(longest: float, lengths: list[float]) -> None:
    assert windows_settings(longest=longest).lengths == pytest.approx(lengths)
