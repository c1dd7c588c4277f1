"""The formula of a run's report becomes the effect `formula` without being typed again."""

from pathlib import Path

import pytest
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.cli.found_formula import found_formula
from dr_lab.errors import ConfigError, DataError
from dr_lab.reports.force_entries import ForceFormulaEntry, MissingForceEntry, TermEntry
from dr_lab.reports.gap import GapReport, Judgement
from dr_lab.reports.gap_entries import ErrorsEntry, LogsEntry, RemainingEntry, RungEntry, WindowsEntry
from dr_lab.reports.json_file import write_json

TERMS = (
    TermEntry("sin(2 [arm position])", 0.2, "N·m", "sin(2 * arm.q)"),
    TermEntry("sign([arm velocity])", -0.1, "N·m", "sign(arm.v)"),
)


def report(folder: Path, terms: tuple[TermEntry, ...] = TERMS) -> GapReport:
    """What a run in a folder says of a force that is missing at the arm."""
    row = MissingForceEntry("arm", "N·m", 0.3, 0.2, 0.01, 0.5, 0.9, ForceFormulaEntry(0.9, 0.8, terms), 60)
    logs, windows = LogsEntry(("log_1",), ("log_2",)), WindowsEntry(0.3, 10, 10, 3)
    remaining, judged = RemainingEntry("unexplained", 9.0), Judgement(missing_force=(row,))
    rung = RungEntry((), ErrorsEntry(1.0, {}), {})
    names = ("dr_lab/gap/1", "close", "furuta", "furuta")
    return GapReport(
        *names, {}, logs, windows, {}, (), "unexplained", (rung,), remaining, str(folder), judgement=judged
    )


def left_by_a_run(folder: Path, terms: tuple[TermEntry, ...] = TERMS) -> None:
    write_json(folder / "report.json", report(folder, terms))


def test_terms_become_parameters_that_start_at_the_reports_values(tmp_path: Path) -> None:
    left_by_a_run(tmp_path)
    cfg = compose("add", ["effect=formula", "effect.joint=arm", f"effect.run={tmp_path}"])
    effect = instantiate(cfg.effects.formula, _convert_="all")
    assert effect.expression == "k1 * (sin(2 * arm.q)) + k2 * (sign(arm.v))"
    assert effect.free["k1"] == {"unit": "N·m", "nominal": 0.0, "low": pytest.approx(-0.6), "high": pytest.approx(0.6)}
    assert effect.start == [{"k1": 0.2, "k2": -0.1}]


def test_what_the_user_writes_takes_no_run() -> None:
    free = "effects.formula.free={k:{unit:Nm,nominal:0,low:-1,high:1}}"
    cfg = compose("add", ["effect=formula", "effect.joint=arm", "effects.formula.expression='-k * q'", free])
    effect = instantiate(cfg.effects.formula, _convert_="all")
    assert (effect.expression, effect.start) == ("-k * q", [])


@pytest.mark.parametrize("joint", ["pole", None])
def test_a_joint_without_a_formula_is_told(tmp_path: Path, joint: str | None) -> None:
    left_by_a_run(tmp_path)
    told = f"no formula for effect.joint={joint}. Available: effect.joint=arm"
    with pytest.raises(ConfigError, match=told):
        found_formula(str(tmp_path), joint, "expression")


@pytest.mark.parametrize(
    ("text", "kind", "told"),
    [
        ("{broken", DataError, r"report\.json cannot be read: Expecting property name"),
        ("[1]", ConfigError, r"holds a report of schema None; expected 'dr_lab/gap/1'"),
        ('{"schema": "dr_lab/train/1"}', ConfigError, r"effect\.run=.* schema 'dr_lab/train/1'; .* close, diagnose or"),
        ('{"schema": "dr_lab/gap/1"}', DataError, "(?s)is a required property.*Run it again"),
    ],
)
def test_a_report_of_another_kind_is_told(text: str, kind: type[Exception], told: str, tmp_path: Path) -> None:
    (tmp_path / "report.json").write_text(text, "utf-8")
    with pytest.raises(kind, match=told):
        found_formula(str(tmp_path), "arm", "expression")


def test_without_a_run_both_ways_are_told(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"effects\.formula\.expression .* or effect\.run=FOLDER"):
        found_formula(None, "arm", "free", 3.0)
    with pytest.raises(ConfigError, match=r"holds no report\.json"):
        found_formula(str(tmp_path), "arm", "free", 3.0)
    left_by_a_run(tmp_path, tuple(TermEntry(each.term, each.coefficient, each.unit) for each in TERMS))
    with pytest.raises(ConfigError, match="of an older dr_lab"):
        found_formula(str(tmp_path), "arm", "free", 3.0)
