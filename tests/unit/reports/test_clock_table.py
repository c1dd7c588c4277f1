from dr_lab.reports.tables import clock_table
from dr_lab.trajectory import ClockFit


def test_a_clock_that_was_not_aligned_has_no_jitter() -> None:
    aligned = ClockFit("header", 0.0123, 2.1e-5, 0.0004)
    told = clock_table({"a": {"q.position": aligned, "motor": ClockFit("log", 0.0, 0.0, 0.0)}})
    assert "| a | `q.position` | header | 0.0123 s | 21 ppm | 0.4 ms |" in told
    assert "| a | `motor` | log | – | – | – |" in told


def test_a_single_clock_is_told_in_a_sentence() -> None:
    taken = ClockFit("column", 0.0, 0.0, 0.0)
    told = clock_table({log: {"q.position": taken, "motor": taken} for log in "ab"})
    assert told == "No clock was aligned: all times are those of the table's time column, as they are."
    both = clock_table(
        {"a": {"q.position": ClockFit("publish", 0.0, 0.0, 0.0), "motor": ClockFit("log", 0.0, 0.0, 0.0)}}
    )
    assert "all times are those of the publishers and the log, as they are" in both
    assert clock_table({}) == ""
