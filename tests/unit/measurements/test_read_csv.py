"""CSV files to logs: units and combinations, defects, rates, cuts, and columns that hold nothing."""

from pathlib import Path

import numpy as np
import pytest
from csv_logs import ANGLE, TIME, Q, U, csv

from dr_lab.errors import DataError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.log import TimeAxis, read_log
from dr_lab.measurements.read import read


def test_sign_scale_offset_and_combinations_make_joint_angles(tmp_path: Path, contract: DataContract) -> None:
    path = csv(tmp_path / "a.csv", time=TIME, one=ANGLE + np.pi, both=ANGLE + np.pi + 0.5 * ANGLE)
    outputs = {
        "one.position": {"column": "one", "unit": "rad", "offset": -np.pi},
        "two.position": {"column": {"both": 1, "one": -1}, "unit": "rad", "sign": -1, "scale": 2},
    }
    log = read_log(path, outputs, {}, contract)
    np.testing.assert_allclose(log.outputs["one.position"].value, ANGLE, atol=1e-7)
    np.testing.assert_allclose(log.outputs["two.position"].value, -ANGLE, atol=1e-7)


def test_every_defect_is_repaired_and_noted(tmp_path: Path, contract: DataContract) -> None:
    rng = np.random.default_rng(0)
    time, wrapped = TIME.copy(), np.mod(3 * TIME + np.pi, 2 * np.pi) - np.pi + 1e-3 * rng.normal(size=len(TIME))
    wrapped[700] += 0.1
    wrapped[[100, 101]] = np.nan
    time[301] = time[300]
    time[500:540] -= 0.1
    time[1200:] += 0.3
    path = csv(tmp_path / "a.csv", time=time, q=wrapped)
    log = read_log(path, {"q.position": {"column": "q", "unit": "rad", "wrap": True}}, {}, contract)
    counts = {note.kind: note.count for note in log.notes}
    assert counts == {"nan": 2, "duplicates": 1, "back_steps": 40, "wrapped": 2, "glitches": 1, "gap": 2}
    signal = log.outputs["q.position"]
    assert len(signal) == 2000 - 2 - 1 - 40 - 1
    truth = 3 * np.where(signal.time > 2.4 - 1e-9, signal.time - 0.3, signal.time)
    np.testing.assert_allclose(signal.value, truth, atol=6e-3)


def test_an_output_that_never_changes_while_a_command_does_is_noted(tmp_path: Path, contract: DataContract) -> None:
    path = csv(tmp_path / "a.csv", time=TIME, q=0.1, u=np.sign(ANGLE))
    (note,) = read_log(path, Q, U, contract).notes
    assert (note.kind, note.signal, note.count) == ("constant", "q.position", 2000)
    assert "q.position: never changes (2000 equal samples) while m is driven. Check its sensor" in note.message


@pytest.mark.parametrize(
    ("angle", "command"),
    [
        (0.1 * (TIME > 2.0), 1.0 * (TIME > 1.9)),  # at rest, then driven
        (0.1 * (TIME > 3.9), 1.0 * (TIME > 1.9)),
        (0.1, 2.0),  # at rest, as commanded
        (0.1, np.where(TIME == 0.0, 1.0, np.nan)),  # sent once
    ],
)
def test_a_machine_at_rest_is_not_noted(tmp_path: Path, contract: DataContract, angle: object, command: object) -> None:
    path = csv(tmp_path / "a.csv", time=TIME, q=angle, u=command)
    assert "constant" not in {note.kind for note in read_log(path, Q, U, contract).notes}


def test_commands_outside_of_the_measured_seconds_drive_nothing(tmp_path: Path, contract: DataContract) -> None:
    path = csv(tmp_path / "a.csv", time=TIME, q=np.where(TIME < 2.0, 0.1, np.nan), u=1.0 * (TIME > 2.5))
    assert "constant" not in {note.kind for note in read_log(path, Q, U, contract).notes}


def test_channels_of_different_rates_keep_their_samples(tmp_path: Path, contract: DataContract) -> None:
    slow = np.where(np.arange(2000) % 10 == 0, ANGLE, np.nan)
    log = read_log(
        csv(tmp_path / "a.csv", time=TIME, q=ANGLE, r=slow),
        {**Q, "r.position": {"column": "r", "unit": "rad"}},
        {},
        contract,
    )
    assert (len(log.outputs["q.position"]), len(log.outputs["r.position"])) == (2000, 200)


def test_vector_channels_and_time_cut(tmp_path: Path, contract: DataContract) -> None:
    path = csv(tmp_path / "a.csv", t=1e3 * TIME, x=ANGLE, y=-ANGLE, u=TIME)
    outputs = {"sensor.gyro": {"column": ["x", "y"], "unit": "deg/s"}}
    axis = TimeAxis("t", "ms", start=1.0, stop=2.0)
    log = read_log(path, outputs, U, contract, time=axis)
    gyro = log.outputs["sensor.gyro"]
    assert (gyro.unit, gyro.value.shape) == ("rad/s", (501, 2))
    assert (gyro.time[0], gyro.time[-1]) == (1.0, 2.0)
    np.testing.assert_allclose(gyro.value[:, 0], np.deg2rad(ANGLE[500:1001]), atol=1e-8)


def test_degrees_declared_as_radians_are_refused(tmp_path: Path, contract: DataContract) -> None:
    path = csv(tmp_path / "a.csv", time=TIME, q=np.rad2deg(ANGLE))
    with pytest.raises(DataError, match=r"factor 57\.3 = 180/π is suspected"):
        read_log(path, Q, {}, contract)


@pytest.mark.parametrize(("scale", "unit", "remedy"), [(1e9, "ns", "1e-9"), (1e6, "µs", "1e-6"), (1e3, "ms", "1e-3")])
def test_times_in_another_unit_than_declared_are_refused_with_the_scale(
    tmp_path: Path, contract: DataContract, scale: float, unit: str, remedy: str
) -> None:
    path = csv(tmp_path / "a.csv", time=scale * TIME, q=ANGLE)
    with pytest.raises(DataError, match=rf"'q\.position' \(column q\).* in {unit}, set time\.scale={remedy}, or raise"):
        read_log(path, Q, {}, contract)
    log = read_log(path, Q, {}, contract, time=TimeAxis(scale=float(remedy)))
    np.testing.assert_allclose(log.outputs["q.position"].time, TIME, atol=1e-9)


@pytest.mark.parametrize(
    ("row", "stamp", "cut", "axis"),
    [(0, -1.7e9, "start", TimeAxis(start=8.5e8)), (-1, 1.7e9, "stop", TimeAxis(stop=8.5e8))],
)
def test_a_stamp_from_another_epoch_is_refused_and_can_be_cut_off(
    tmp_path: Path, contract: DataContract, row: int, stamp: float, cut: str, axis: TimeAxis
) -> None:
    time = TIME.copy()
    time[row] = stamp
    path = csv(tmp_path / "a.csv", time=time, q=ANGLE)
    with pytest.raises(DataError, match=rf"2000 samples in 1\.7e\+09 s.* Cut them off with time\.{cut}=8\.5e\+08,"):
        read_log(path, Q, {}, contract)
    log = read_log(path, Q, {}, contract, time=axis)
    assert len(log.outputs["q.position"]) == 1999


@pytest.mark.parametrize("unit", ["deg", "Hz", "m"])
def test_a_unit_that_is_none_of_time_is_refused(tmp_path: Path, contract: DataContract, unit: str) -> None:
    path = csv(tmp_path / "a.csv", time=TIME, q=ANGLE)
    with pytest.raises(DataError, match=rf"time\.unit is '{unit}' of dimension .*; expected s, ms"):
        read_log(path, Q, {}, contract, time=TimeAxis(unit=unit))


def test_a_constant_command_holds(tmp_path: Path, contract: DataContract) -> None:
    u = np.where(np.arange(2000) == 0, 3.0, np.nan)
    log = read_log(csv(tmp_path / "a.csv", time=TIME, q=ANGLE, u=u), Q, U, contract)
    np.testing.assert_array_equal(log.commands["m"].value, [3.0])


def test_an_edge_of_a_command_may_be_two_rows_of_one_time(tmp_path: Path, contract: DataContract) -> None:
    time = np.repeat(TIME, 2)[1:]
    level = np.where(TIME < 2.0, -1.0, 1.0)
    path = csv(tmp_path / "a.csv", time=time, q=np.repeat(ANGLE, 2)[1:], u=np.repeat(level, 2)[:-1])
    log = read_log(path, Q, U, contract)
    np.testing.assert_array_equal(log.commands["m"].value[:-1], level[:-1])
    np.testing.assert_array_equal(log.commands["m"].time, log.outputs["q.position"].time)


def test_too_few_samples_say_what_became_of_the_others(tmp_path: Path, contract: DataContract) -> None:
    path = csv(tmp_path / "a.csv", time=TIME[::-1], q=ANGLE)
    with pytest.raises(DataError, match=r"1 usable samples; .* q\.position: time goes back .* the 1999 samples before"):
        read_log(path, Q, {}, contract)


def test_a_cut_table_is_told_by_each_of_its_groups(tmp_path: Path, contract: DataContract) -> None:
    path = csv(tmp_path / "a.csv", time=TIME, q=ANGLE, g=np.repeat([1, 2], 1000))
    path.write_text(path.read_text()[:-8])
    found = read("bench", [str(path)], Q, contract, group="g")
    assert [(log.name, [note.kind for note in log.notes]) for log in found.fit] == [("a/1", ["cut"]), ("a/2", ["cut"])]


def test_all_nan_and_one_sample(tmp_path: Path, contract: DataContract) -> None:
    with pytest.raises(DataError, match=r"'q.position': all 2000 cells are empty or no finite numbers"):
        read_log(csv(tmp_path / "a.csv", time=TIME, q=np.nan), Q, {}, contract)
    with pytest.raises(DataError, match=r"'q.position' \(column q\) has 1 usable samples; at least 20 are needed"):
        read_log(csv(tmp_path / "b.csv", time=[0.0], q=[1.0]), Q, {}, contract)
    path = csv(tmp_path / "c.csv", time=TIME, q=ANGLE)
    with pytest.raises(DataError, match=r"has no sample in the chosen time; time\.start and stop left none"):
        read_log(path, Q, {}, contract, time=TimeAxis(start=9.0))
    with pytest.raises(DataError, match=r"'c\[7:8\]': .* no sample in the chosen time; they lie from 0 to 3\.998 s"):
        read("bench", [str(path)], Q, contract, fit=["c[7:8]"])
