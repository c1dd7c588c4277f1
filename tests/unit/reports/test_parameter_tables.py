"""Parameters in tables: as they are given or fitted, and as each log alone gives them."""

from dr_lab.reports.gap_entries import LogScatterEntry, ParameterEntry
from dr_lab.reports.tables import parameter_table, per_log_table


def of_logs(*values: float, unit: str = "kg") -> ParameterEntry:
    scatter = LogScatterEntry(per_log={f"log_{k}": value for k, value in enumerate(values, start=1)})
    return ParameterEntry(values[0], 0.1, unit, scatter=scatter)


def test_logs_that_differ_by_little_are_told_with_the_digits_that_differ() -> None:
    told = per_log_table({"arm.mass": of_logs(0.104571, 0.104643), "gear.ratio": of_logs(2.0, 3.0, unit="1")})
    assert "| `arm.mass` [kg] | 0.10457 | 0.10464 |" in told
    assert "| `gear.ratio` | 2 | 3 |" in told


def test_logs_that_agree_have_no_endless_digits() -> None:
    assert "| 0.105 | 0.105 |" in per_log_table({"arm.mass": of_logs(0.104571, 0.104571)})
    assert "| 0.104571 | 0.104571 |" in per_log_table({"arm.mass": of_logs(0.104571, 0.1045710000001)})


def test_values_as_given_are_not_said_to_have_a_deviation() -> None:
    given = {"arm.mass": ParameterEntry(0.38, None, "kg")}
    assert parameter_table(given, {}).splitlines()[0] == "| parameter | value |"
    fitted = {"arm.mass": ParameterEntry(0.38, 0.01, "kg")}
    assert parameter_table(fitted, {}).splitlines()[0] == "| parameter | value ± std |"
