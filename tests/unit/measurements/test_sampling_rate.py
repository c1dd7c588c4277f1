"""Times that are none of a machine are refused, and what the message proposes is then accepted."""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from csv_logs import Q, csv

from dr_lab.errors import DataError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.log import read_log
from dr_lab.measurements.raw_log import TimeAxis
from dr_lab.measurements.sampling import check_sampling
from dr_lab.recorders.mcap import FloatArrays, JointStates, write_mcap
from dr_lab.trajectory import Array

ARM = {"arm.position": {"topic": "/joint_states", "field": "position[arm]", "unit": "rad"}}
TIME = np.linspace(0.0, 2.0, 500, endpoint=False)


def moves(count: int, duration: float, every: float) -> Array:
    """Changes at 100 Hz, published as long as the joint moves."""
    return np.concatenate([every * move + np.arange(0.0, duration, 0.01) for move in range(count)])


@pytest.mark.parametrize(
    ("time", "keys", "kept"),
    [
        (moves(5, 0.3, 400.0), ["stop"], 30),
        (np.concatenate([[0.0], 1.7e9 + moves(1, 0.3, 0.0), [1.7e9 + 400.0]]), ["start", "stop"], 30),
        (np.concatenate([[-1.7e9, -1.2e9], moves(1, 3.0, 0.0)]), ["start"], 300),
        (np.concatenate([moves(2, 1.0, 5.0), [1.7e9]]), ["stop"], 200),
    ],
    ids=["pauses", "a stamp at either end", "two strays", "a pause that is none of the strays"],
)
def test_the_proposed_cut_keeps_the_best_stretch(
    tmp_path: Path, contract: DataContract, time: Array, keys: Sequence[str], kept: int
) -> None:
    path = tmp_path / "a.csv"
    path.write_text("time,q\n" + "".join(f"{t!r},{float(np.sin(t))!r}\n" for t in time.tolist()))
    with pytest.raises(DataError, match=r"stamps lie far from the others.* published at a steady rate") as raised:
        read_log(path, Q, {}, contract)
    cuts = dict(re.findall(r"time\.(\w+)=([-+.\de]+)", str(raised.value)))
    assert list(cuts) == keys
    start, stop = (float(cuts[key]) if key in cuts else None for key in ("start", "stop"))
    log = read_log(path, Q, {}, contract, time=TimeAxis(start=start, stop=stop))
    assert len(log.outputs["q.position"]) == kept


def test_pauses_are_not_taken_for_another_unit(contract: DataContract) -> None:
    with pytest.raises(DataError, match=r"No stretch between such pauses has 20 samples.*contract\.longest_period"):
        check_sampling("q", moves(10, 0.1, 40.0), "log", contract)


@pytest.mark.parametrize("clock", ["header", "publish", "log"])
def test_the_clock_that_is_refused_is_not_proposed(contract: DataContract, clock: str) -> None:
    with pytest.raises(DataError) as raised:
        check_sampling("q", np.arange(0.0, 400.0, 4.0), clock, contract)
    proposed = re.search(rf"another clock than {clock}: (\w+) or (\w+)", str(raised.value))
    assert proposed
    assert {*proposed.groups(), clock} == {"header", "publish", "log"}


def test_a_log_that_is_merely_short_asks_for_a_longer_one(tmp_path: Path, contract: DataContract) -> None:
    time = 0.01 * np.arange(10)
    path = csv(tmp_path / "a.csv", time=time, q=np.where(time == 0.05, np.nan, time))
    with pytest.raises(DataError, match=r"has 9 usable samples; .* 1 of 10 cells are empty .* Give a longer log"):
        read_log(path, Q, {}, contract)
    value = np.where(np.arange(40) % 4 > 0, np.nan, np.arange(40.0))
    path = csv(tmp_path / "b.csv", time=0.01 * np.arange(40), q=value)
    with pytest.raises(DataError, match=r"has 10 usable samples; .* 30 of 40 cells are empty .* Mend that in the file"):
        read_log(path, Q, {}, contract)


@pytest.mark.parametrize(
    ("clock", "message"),
    [
        ("log", r"all log stamps are equal, nobody set them\. Choose another clock: header\."),
        ("header", r"all log times are equal, .* Write the file again with log times"),
    ],
)
def test_log_times_that_nobody_set_are_refused(
    tmp_path: Path, contract: DataContract, clock: str, message: str
) -> None:
    states = JointStates("/joint_states", ("arm",), 1.7e9 + TIME, np.zeros(500), np.sin(TIME)[:, None])
    write_mcap(tmp_path / "a.mcap", [states], {}, {})
    with pytest.raises(DataError, match=message):
        read_log(tmp_path / "a.mcap", ARM, {}, contract, clock=clock)


@pytest.mark.parametrize(
    ("clock", "message"),
    [
        ("log", r"do not overlap in time\. Record them together"),
        ("publish", r"clocks \(publish and publish\) .* one of them: header or log\. Record them together"),
    ],
)
def test_signals_of_one_clock_that_do_not_overlap_are_not_sent_back_to_it(
    tmp_path: Path, contract: DataContract, clock: str, message: str
) -> None:
    states = JointStates("/joint_states", ("arm",), TIME, TIME, np.sin(TIME)[:, None])
    write_mcap(tmp_path / "a.mcap", [states, FloatArrays("/u", ("u",), TIME + 100.0, TIME[:, None])], {}, {})
    with pytest.raises(DataError, match=message):
        read_log(tmp_path / "a.mcap", ARM, {"u": {"topic": "/u", "field": "data", "unit": "V"}}, contract, clock=clock)


def test_seconds_read_as_milliseconds_are_named_as_that(tmp_path: Path, contract: DataContract) -> None:
    path = csv(tmp_path / "a.csv", time=TIME, q=np.sin(TIME), v=np.cos(TIME))
    outputs = {"q.position": {"column": "q", "unit": "rad"}, "q.velocity": {"column": "v", "unit": "rad/s"}}
    with pytest.raises(DataError, match=r"a sample every 4e-06 s.*another unit than declared.*1e3 times longer"):
        read_log(path, outputs, {}, contract, time=TimeAxis(unit="ms"))
    slow = csv(
        tmp_path / "b.csv", time=0.1 * np.arange(200), q=np.sin(0.1 * np.arange(200)), v=np.cos(0.1 * np.arange(200))
    )
    with pytest.raises(DataError, match=r"times q\.velocity: the times seem to be s that are read as ms"):
        read_log(slow, outputs, {}, contract, time=TimeAxis(unit="ms"))
    fast = csv(
        tmp_path / "c.csv", time=0.2 * np.arange(500), q=np.sin(2e-4 * np.arange(500)), v=np.cos(2e-4 * np.arange(500))
    )
    with pytest.raises(DataError, match=r"the times seem to be ms that are read as s"):
        read_log(fast, outputs, {}, contract)
