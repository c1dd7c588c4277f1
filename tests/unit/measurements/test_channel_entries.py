"""Entries of channels and of the time that are none: what the message says."""

from pathlib import Path
from typing import Any, cast

import pytest
from csv_logs import ANGLE, TIME, csv

from dr_lab.errors import ConfigError, DataError, UnknownNameError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.log import read_log
from dr_lab.measurements.raw_log import TimeAxis


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"unit": "V"}, DataError, r"unit 'V' has dimension .*a joint's position is measured in rad, deg, m or mm"),
        ({"unit": "radd"}, DataError, r"no unit 'radd'"),
        ({"unit": None}, ConfigError, r"give its unit"),
        ({"sign": 2}, ConfigError, r"sign must be 1 or -1; got 2"),
        ({"scale": 0}, ConfigError, r"scale is 0, which leaves nothing"),
        ({"column": []}, ConfigError, r"got neither"),
        ({"noise_std": 0.0}, ConfigError, r"noise_std must be > 0"),
        ({"noise_std": float("nan")}, ConfigError, r"noise_std is nan; expected a number"),
        ({"between": "holt"}, UnknownNameError, r"no way between samples 'holt' .*Did you mean 'hold'\?"),
        ({"clock": "headr"}, UnknownNameError, r"no clock 'headr' .*Did you mean 'header'\?"),
        ({"scael": 2}, UnknownNameError, r"no key 'scael' .*Did you mean 'scale'\?"),
        ({"topic": "/q"}, ConfigError, r"give topic and field \(MCAP\) or column \(CSV, Parquet\); got column, topic"),
        ({"column": None}, ConfigError, r"got neither"),
        ({"column": 3}, ConfigError, r"3 is neither a name nor a mapping"),
    ],
)
def test_wrong_entries_are_explained(
    tmp_path: Path, contract: DataContract, change: dict[str, Any], error: type[Exception], message: str
) -> None:
    path = csv(tmp_path / "a.csv", time=TIME, q=ANGLE)
    with pytest.raises(error, match=message):
        read_log(path, {"q.position": {"column": "q", "unit": "rad"} | change}, {}, contract)


@pytest.mark.parametrize("entry", [None, "q"])
def test_a_channel_without_an_entry_is_explained(tmp_path: Path, contract: DataContract, entry: object) -> None:
    path = csv(tmp_path / "a.csv", time=TIME, q=ANGLE)
    with pytest.raises(ConfigError, match=r"Channel 'q.position' is .*; expected its entry, e\.g\. \{column: NAME"):
        read_log(path, {"q.position": cast(Any, entry)}, {}, contract)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"scale": "1e-9s"}, r"time\.scale is '1e-9s'; expected a number, e\.g\. 1e-9 for ns"),
        ({"scale": None}, r"time\.scale is None"),
        ({"scale": 0}, r"time\.scale is 0; expected a number above 0"),
        ({"scale": float("nan")}, r"time\.scale is nan"),
        ({"scale": -1.0}, r"time\.scale is -1; expected a number above 0"),
        ({"start": 3.0, "stop": 1.0}, r"time\.start is 3 s and time\.stop 1 s; expected a stop behind the start"),
        ({"start": "1 s"}, r"time\.start is '1 s'; expected a number of seconds"),
    ],
)
def test_a_time_axis_that_is_none_is_explained(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        TimeAxis(**settings)
