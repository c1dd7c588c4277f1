import io

import pytest
from rich.console import Console

from dr_lab.comparison import progress
from dr_lab.comparison.progress import screen


@pytest.fixture
def console(monkeypatch: pytest.MonkeyPatch) -> Console:
    """No terminal, as in a pipe."""
    made = Console(file=io.StringIO(), width=60)
    monkeypatch.setattr(progress, "Console", lambda: made)
    return made


def effects(count: int) -> list[str]:
    return [f"effect_{k}@joint" for k in range(count)]


def printed(console: Console) -> list[str]:
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue().splitlines()


def test_without_a_terminal_each_phase_is_a_line_as_soon_as_it_begins(console: Console) -> None:
    with screen() as told:
        told.phase("Calibrating [the] model")
        assert printed(console) == ["Calibrating [the] model …"]
        told.show("**Found:** it.")
        assert printed(console)[1:] == ["", "Found: it.".ljust(60), ""]


def test_a_ranking_tells_each_quarter(console: Console) -> None:
    with screen() as told:
        done = told.ranking(effects(50))
        for k in range(50):
            done(f"effect_{k}")
    assert printed(console) == [
        "Trying 50 effects …",
        "  13 of 50 tried, the last effect_12",
        "  25 of 50 tried, the last effect_24",
        "  38 of 50 tried, the last effect_37",
        "  50 of 50 tried, the last effect_49",
    ]


def test_a_slow_ranking_tells_every_ten_seconds(console: Console, monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    with screen() as told:
        done = told.ranking(effects(100))
        for k in range(20):
            now += 4.0
            done(f"effect_{k}")
    assert [line.split()[0] for line in printed(console)[1:]] == ["3", "6", "9", "12", "15", "18"]
    assert printed(console)[1] == "  3 of 100 tried, the last effect_2"  # too few to foretell the others


def test_less_than_a_minute_and_a_half_is_told_in_seconds(console: Console, monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    with screen() as told:
        done = told.ranking(effects(4))
        for k in range(4):
            now += 20.0
            done(f"effect_{k}")
    assert [line.partition("; ")[2] for line in printed(console)[1:]] == [
        "60 s left at most", "40 s left at most", "20 s left at most", ""
    ]  # fmt: skip


def test_what_was_found_so_far_is_told(console: Console) -> None:
    with screen() as told:
        told.found(["drag@cart", "lag@motor"], 2124.04, 3.14159)
        told.found([], 2124.04, 2124.04)
    assert printed(console) == [
        "So far: drag@cart, lag@motor; χ² 2124 → 3.142, where 1 is the noise floor",
        "So far: nothing that stands",
    ]


def test_few_effects_are_told_by_name_and_one_is_no_ranking(console: Console) -> None:
    with screen() as told:
        told.ranking(["drag"])("drag")
    assert printed(console) == ["Trying drag …"]


def test_on_a_terminal_there_is_a_bar_and_what_is_shown_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    made = Console(file=io.StringIO(), force_terminal=True, width=80)
    monkeypatch.setattr(progress, "Console", lambda: made)
    with screen() as told:
        told.phase("Calibrating the model")
        done = told.ranking(effects(2))
        done("drag")
        told.found(["drag"], 9.0, 1.0)
        told.show("**Found:** drag.")
        told.phase("Writing the report")
    assert isinstance(made.file, io.StringIO)
    text = made.file.getvalue()
    assert "So far: drag; χ² 9 → 1" in text
    assert "Found:" in text
    assert "Writing the report" in text
    assert "Writing the report …" not in text


def test_a_ranking_that_is_made_anew_counts_anew(console: Console) -> None:
    with screen() as told:
        done = told.ranking(["drag@cart", "lag@motor"])
        for label in ("drag@cart", "lag@motor", "drag@cart", "lag@motor"):
            done(label)
    assert printed(console) == [
        "Trying drag@cart, lag@motor …",
        "  1 of 2 tried, the last drag@cart",
        "  2 of 2 tried, the last lag@motor",
        "The model itself was found to fit better: trying all anew …",
        "  1 of 2 tried, the last drag@cart",
        "  2 of 2 tried, the last lag@motor",
    ]
