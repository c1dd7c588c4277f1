"""Tables that hold several logs each, told apart by a column, and wildcards over the logs' names."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
from csv_logs import Q, csv

from dr_lab.errors import ConfigError, DataError, UnknownNameError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.read import read
from dr_lab.measurements.split import split
from dr_lab.measurements.table import grouped

STEPS = np.arange(100)


@pytest.fixture
def tosses(tmp_path: Path) -> Path:
    """Three tosses of a hundred steps each, whose angle grows with its own rate; steps count anew in each."""
    toss, step = (part.ravel() for part in np.meshgrid([7, 30, 31], STEPS, indexing="ij"))
    return csv(tmp_path / "tosses.csv", toss=toss, step=step, q=1e-3 * toss * step)


def test_every_value_of_the_column_is_a_log_on_its_own_clock(tosses: Path, contract: DataContract) -> None:
    time = {"column": "step", "unit": "ms", "scale": 10}
    found = read("t", [str(tosses)], Q, contract, held_out=["tosses/7"], time=time, group="toss")
    assert [log.name for log in found.fit] == ["tosses/30", "tosses/31"]
    assert [log.name for log in found.held_out] == ["tosses/7"]
    for log in (*found.fit, *found.held_out):
        signal, toss = log.outputs["q.position"], int(log.name.removeprefix("tosses/"))
        np.testing.assert_allclose(signal.time, 0.01 * STEPS, atol=1e-12)
        np.testing.assert_allclose(signal.value, 1e-3 * toss * STEPS, atol=1e-9)


def test_stretches_of_grouped_logs(tosses: Path, contract: DataContract) -> None:
    time = {"column": "step", "unit": "s", "scale": 0.01}
    found = read("t", [str(tosses)], Q, contract, fit=["*/3?[0:0.5]"], held_out=["*[0.6:]"], time=time, group="toss")
    assert [log.name for log in found.fit] == ["tosses/30[0:0.5]", "tosses/31[0:0.5]"]
    assert [len(log.outputs["q.position"]) for log in found.held_out] == [40, 40, 40]


def test_a_group_without_values_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t,q,toss\n0,1,\n1,2,\n")
    with pytest.raises(DataError, match=r"column 'toss' holds no value, so it tells no logs apart\. Correct group"):
        grouped(path, "toss")


def test_wrong_groups_are_explained(tosses: Path, contract: DataContract) -> None:
    with pytest.raises(UnknownNameError, match=r"no column 'tos' in tosses\.csv\. Did you mean 'toss'"):
        read("t", [str(tosses)], Q, contract, group="tos")
    with pytest.raises(UnknownNameError, match=r"no log 'tosses' in logs\. .*Available: tosses/30, tosses/31"):
        read("t", [str(tosses)], Q, contract, fit=["tosses"], group="toss")
    tosses.with_suffix(".mcap").write_bytes(b"")
    with pytest.raises(ConfigError, match=r"group is 'toss', a column of tables .* but tosses\.mcap is none"):
        read("t", [str(tosses.with_suffix(".mcap"))], Q, contract, group="toss")


def test_groups_keep_their_order_and_leave_out_rows_without_a_value(tmp_path: Path) -> None:
    table = pa.table({"run": ["b", "a", None, "b"], "half": [0.5, 1.0, 1.0, 0.5]})
    pyarrow.parquet.write_table(table, tmp_path / "runs.parquet")
    found = grouped(tmp_path / "runs.parquet", "run")
    assert {name: rows.table.num_rows for name, rows in found.items()} == {"b": 2, "a": 1}
    assert list(found) == ["b", "a"]
    assert list(grouped(tmp_path / "runs.parquet", "half")) == ["0.5", "1"]


def test_groups_of_long_numbers_stay_apart(tmp_path: Path) -> None:
    pyarrow.parquet.write_table(pa.table({"day": [20210414.0, 20210415.0, None]}), tmp_path / "days.parquet")
    assert list(grouped(tmp_path / "days.parquet", "day")) == ["20210414", "20210415"]


def test_wildcards_take_every_log_that_fits_once() -> None:
    logs = ["a_1", "a_2", "a_10", "b_1"]
    assert [part.name for part in split(logs, ["a_[12]"], None)[0]] == ["a_1", "a_2"]
    fitted, scored = split(logs, ["a_?", "*_1"], ["a_??[1:2]"])
    assert [part.name for part in fitted] == ["a_1", "a_2", "b_1"]
    assert [(part.name, part.log, part.start, part.stop) for part in scored] == [("a_10[1:2]", "a_10", 1.0, 2.0)]
    with pytest.raises(ConfigError, match=r"'a_1' \(fit\) and 'a_1\[0:3\]' \(held_out\) share data"):
        split(logs, ["a_*"], ["?_1[0:3]"])
    with pytest.raises(UnknownNameError, match=r"no log 'c_\*'"):
        split(logs, ["c_*"], None)
