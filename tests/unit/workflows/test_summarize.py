import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rerun as rr
from written_runs import STATISTICS, train_report, trained, two_kinds, write_configuration, write_run

from dr_lab.__main__ import main
from dr_lab.errors import DataError
from dr_lab.reports.places import beside
from dr_lab.summaries.groups import figures_of, grouped, summed_up
from dr_lab.summaries.overlays import bands
from dr_lab.summaries.runs import find_runs, picked, units
from dr_lab.sweeps.overrides import differing

FIGURES = {"dr_lab/train/1": ["final_return", "context.*.mean"], "dr_lab/gap/1": ["verdict", "remaining.chi2"]}


@pytest.fixture
def sweep(tmp_path: Path) -> Path:
    return two_kinds(tmp_path / "sweep")


def test_runs_come_in_the_order_of_their_numbers_and_the_unfinished_are_named(sweep: Path) -> None:
    runs, unfinished = find_runs(sweep)
    assert [run.name for run in runs] == ["0", "1", "2", "10", "11", "12"]
    assert unfinished == ["20"]
    assert differing([run.overrides for run in runs]) == ["seed", "learner"]


def test_seeds_are_taken_together_by_their_interquartile_mean(sweep: Path) -> None:
    groups = grouped(find_runs(sweep)[0], ["seed"])
    assert [(group.label, len(group.runs)) for group in groups] == [("lsdr", 3), ("none", 3)]
    cell: Any = summed_up(groups[0], FIGURES, STATISTICS)["final_return"]
    assert cell.value == 11.0  # a quarter of three values is none: their mean
    assert 10.0 <= cell.low < 11.0 < cell.high <= 12.0
    same: Any = summed_up(groups[1], FIGURES, STATISTICS)["final_return"]
    assert (same.value, same.low, same.high) == (4.0, 4.0, 4.0)


def test_runs_that_differ_in_nothing_are_one_group(tmp_path: Path) -> None:
    trained(tmp_path / "a", 1.0, [1.0, 0.0], "seed=0")
    (group,) = grouped(find_runs(tmp_path)[0], ["seed"])
    assert (group.label, dict(group.settings)) == ("all runs", {})
    cell: Any = summed_up(group, FIGURES, STATISTICS)["final_return"]
    assert cell.value == 1.0
    assert np.isnan(cell.low)


@pytest.mark.parametrize(
    "typed",
    [
        ["env.context.mass.low=0.1", "env.context.length.low=0.1", "env.context.length.low=0.2"],
        ["randomizer=none", "learner=none"],
        ["init_distribution=true", "init_distribution=false"],
        ["init=null", "init=outputs/train/hopper"],
    ],
)
def test_groups_have_keys_where_values_say_too_little(typed: list[str], tmp_path: Path) -> None:
    for number, override in enumerate(typed):
        trained(tmp_path / str(number), 1.0, [1.0, 0.0], override)
    groups = grouped(find_runs(tmp_path)[0], ["seed"])
    assert [group.label for group in groups] == typed
    assert [band.group for band in bands(groups, STATISTICS)] == typed


def test_runs_configured_otherwise_are_no_further_seeds(tmp_path: Path) -> None:
    for number, (seed, low, threads) in enumerate([(0, 0.1, 1), (1, 0.1, 2), (2, 0.5, 1), (0, 0.1, 4)]):
        trained(tmp_path / f"sweep/{number}", 1.0, [1.0, 0.0], f"seed={seed}")
        configured = {"seed": seed, "threads": threads, "env": {"size": {"low": low}}, "outputs": str(number)}
        write_configuration(tmp_path / f"sweep/{number}", configured, f"seed={seed}")
    folder = tmp_path / "summary"
    figures = "figures={dr_lab/train/1:[final_return]}"
    assert main(["summarize", f"sweep={tmp_path / 'sweep'}", f"hydra.run.dir={folder}", figures]) == 0
    report = json.loads((folder / "report.json").read_text("utf-8"))
    assert [group["runs"] for group in report["groups"]] == [["0", "1", "3"], ["2"]]
    first, second = (group["settings"]["configuration"] for group in report["groups"])
    twice, apart = report["notes"]
    assert twice.endswith("counts 2 times: 0, 3.")
    assert "configured differently (env.size.low)" in apart
    assert apart.endswith(f"configuration={first}: 0, 1, 3; configuration={second}: 2.")


def test_seeds_of_several_experiments_are_taken_together_where_that_is_asked(tmp_path: Path) -> None:
    for name, low in (("night", 0.1), ("day", 0.5)):
        trained(tmp_path / name, 1.0, [1.0, 0.0], f"experiment={name}")
        write_configuration(tmp_path / name, {"seed": 0, "low": low}, f"experiment={name}")
    runs, _ = find_runs(tmp_path)
    assert [group.label for group in grouped(runs, ["seed"])] == ["day", "night"]
    assert [group.label for group in grouped(runs, ["experiment"])] == ["all runs"]


def test_words_are_counted(tmp_path: Path) -> None:
    for seed, verdict in enumerate(["named", "named", "none"]):
        report = {"schema": "dr_lab/gap/1", "verdict": verdict, "remaining": {"chi2": 1.0}}
        write_run(tmp_path / str(seed), report, f"seed={seed}")
        (tmp_path / str(seed) / "metrics.csv").write_text("model,channel\nas given,arm\n", "utf-8")
    (group,) = grouped(find_runs(tmp_path)[0], ["seed"])
    assert bands([group], STATISTICS) == []  # nothing was trained
    assert summed_up(group, FIGURES, STATISTICS)["verdict"] == {"named": 2, "none": 1}
    assert figures_of(group.runs[2], FIGURES) == {"verdict": "none", "remaining.chi2": 1.0}


def test_a_figure_counts_the_runs_that_have_it(tmp_path: Path) -> None:
    for seed, final in enumerate([None, 2.0, None, 4.0, 6.0]):
        report = train_report(final, {})
        write_run(tmp_path / f"sweep/good/{seed}", report, "env=hopper", f"seed={seed}")
        lost = report | {"final_return": None}
        write_run(tmp_path / f"sweep/lost/{seed}", lost, "env=walker", f"seed={seed}")
    folder = tmp_path / "summary"
    assert main(["summarize", f"sweep={tmp_path / 'sweep'}", f"hydra.run.dir={folder}"]) == 0
    page = (folder / "report.md").read_text("utf-8")
    assert "| final_return | hopper | 3 of 5 | 4 (2 … 6) |" in page
    assert "Intervals of few runs cover less: of 3 runs 75 %, of 5 runs 94 % at most." in page
    assert "| final_return | walker | 0 of 5 | – |" in page
    with (folder / "groups.csv").open(encoding="utf-8", newline="") as file:
        assert [(row["runs"], row["final_return runs"]) for row in csv.DictReader(file)] == [("5", "3"), ("5", "0")]
    good, lost = json.loads((folder / "report.json").read_text("utf-8"))["groups"]
    assert (good["figures"]["final_return"]["runs"], len(good["runs"])) == (3, 5)
    assert lost["figures"]["final_return"] == {"iqm": None, "low": None, "high": None, "runs": 0}
    with (folder / "runs.csv").open(encoding="utf-8", newline="") as file:
        assert [row["final_return"] for row in csv.DictReader(file)][:5] == ["", "2.0", "", "4.0", "6.0"]


def test_paths_pick_from_a_report() -> None:
    report = {"a": {"b": 1, "c": None, "d": True}, "ladder": [{"chi2": 2.5}], "word": "yes"}
    found = picked(report, ["a.*", "ladder.0.chi2", "ladder.1.chi2", "word", "missing"])
    assert np.isnan(float(found.pop("a.c")))
    assert found == {"a.b": 1.0, "ladder.0.chi2": 2.5, "word": "yes"}


def test_a_key_that_holds_dots_is_found_by_its_full_path() -> None:
    report = {"figures": {"uniform.iqm": 3.0}, "context": {"arm.mass": {"unit": "kg", "mean": 2.0}}}
    paths = ["figures.uniform.iqm", "context.arm.mass.mean"]
    assert picked(report, paths) == {"figures.uniform.iqm": 3.0, "context.arm.mass.mean": 2.0}
    assert units(report, paths) == {"context.arm.mass.mean": "kg"}
    assert beside(report, "context.arm.mass.men") == ["context.arm.mass.unit", "context.arm.mass.mean"]


def test_figures_have_the_units_beside_them() -> None:
    report = {"seconds": 3.0, "context": {"arm.mass": {"unit": "kg", "mean": 2.0}, "wind": {"unit": "m/s"}}}
    assert units(report, ["seconds", "context.*.mean"]) == {"context.arm.mass.mean": "kg", "context.wind.mean": "m/s"}


def test_the_verb_writes_tables_and_a_recording(sweep: Path, tmp_path: Path) -> None:
    folder = tmp_path / "summary"
    assert main(["summarize", f"sweep={sweep}", f"hydra.run.dir={folder}"]) == 0
    with (folder / "runs.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["seed"] for row in rows] == ["0", "1", "2", "0", "1", "2"]
    assert [float(row["final_return"]) for row in rows] == [10.0, 11.0, 12.0, 4.0, 4.0, 4.0]
    with (folder / "groups.csv").open(encoding="utf-8", newline="") as file:
        groups = list(csv.DictReader(file))
    assert [(row["learner"], row["runs"], row["final_return"]) for row in groups] == [
        ("lsdr", "3", "11.0"),
        ("none", "3", "4.0"),
    ]
    page = (folder / "report.md").read_text("utf-8")
    assert "| final_return | lsdr | 3 | 11 (10 … 12) |" in page
    assert "context.torso.size.mean 0.05 m" in page
    assert "context.torso.size.mean [m]" in (folder / "report.html").read_text("utf-8")
    assert "Without a report: 20." in page
    assert "Without a report: 20." in (folder / "report.html").read_text("utf-8")
    entities = {str(chunk.entity_path) for chunk in rr.chunk.RrdReader(folder / "review.rrd").stream()}
    assert any(path.startswith("/curve/episode_return/") for path in entities)
    assert any(path.startswith("/distribution/torso") for path in entities)


def test_what_no_run_has_is_told(sweep: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "summary"
    command = ["summarize", f"sweep={sweep}", f"hydra.run.dir={folder}"]
    assert main([*command, "figures={dr_lab/train/1:[final_return,context.*.meen,contxt.*.mean]}"]) == 0
    page = (folder / "report.md").read_text("utf-8")
    assert "no figure 'context.*.meen' in reports of schema dr_lab/train/1" in page
    assert "Did you mean 'context.torso.size.mean'?" in page
    assert "no figure 'contxt.*.mean' in reports" in page
    assert "'final_return'" not in page
    assert len(json.loads((folder / "report.json").read_text("utf-8"))["notes"]) == 2
    capsys.readouterr()
    assert main([*command, "figures={dr_lab/train/1:[finl_return]}"]) == 2
    assert "Not one of the figures was found.\nThere is no figure 'finl_return'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("aggregate=[sed]", "no override 'sed' in these runs (aggregate). Did you mean 'seed'?"),
        ("statistics.confidence=95", "statistics.confidence is 95; expected a share between 0 and 1"),
        ("statistics.confidence=0", "statistics.confidence is 0; expected a share between 0 and 1"),
        ("statistics.resamples=0", "statistics.resamples is 0; expected at least 1"),
        ("statistics.seed=-1", "statistics.seed is -1; expected at least 0"),
    ],
)
def test_settings_out_of_their_bounds_are_refused(
    override: str, message: str, sweep: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["summarize", f"sweep={sweep}", f"hydra.run.dir={tmp_path / 'summary'}", override]) == 2
    assert message in capsys.readouterr().err


def test_paths_that_end_at_nothing_are_no_fault() -> None:
    report = {"context": {}, "remaining": None, "final": {"loss": 1.0}}
    assert beside(report, "context.*.mean") == beside(report, "remaining.chi2") == []
    assert beside(report, "final.los") == beside(report, "final") == ["final.loss"]


def test_a_folder_without_runs_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(DataError, match="no run is finished"):
        find_runs(tmp_path)
    assert main(["summarize", f"sweep={tmp_path / 'nowhere'}", f"hydra.run.dir={tmp_path / 'summary'}"]) == 2
    assert "There is no folder" in capsys.readouterr().err


def test_summaries_are_no_runs(
    sweep: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(sweep)
    assert main(["summarize", "sweep=.", "hydra.run.dir=refused", "aggregate=[sed]"]) == 2
    for name in ("first", "second"):
        assert main(["summarize", "sweep=.", f"hydra.run.dir={name}"]) == 0
        page = Path(name, "report.md").read_text("utf-8")
        assert page.startswith("# 6 runs of sweep\n")
        assert "Without a report: 20.\n" in page
    assert "fault" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("report.json", b"{", "Expecting property name"),
        ("report.json", b"[]", "its report.json has no schema"),
        ("report.json", b"{}", "its report.json has no schema"),
        ("report.json", b"\xff", "codec can't decode"),
        ("report.json", b'{"schema": "dr_lab/train/1"}', "report.json does not follow the schema 'dr_lab/train/1'"),
        ("report.json", b'{"schema": "dr_lab/train/1"}', "$: 'context' is a required property"),
        ("report.json", b'{"schema": "dr_lab/evaluate/1", "rows": {}}', "$.rows: {} is not of type 'array'"),
        ("config.yaml", b"made_with: null", "does not say what the run was made with"),
        ("config.yaml", b"- 1", "does not say what the run was made with"),
        ("metrics.csv", b"frames\n\xff\n", "codec can't decode"),
        ("metrics.csv", b"frames\n1,2\n", "Expected the metrics.csv of a training run"),
    ],
)
def test_a_broken_run_is_named(
    name: str, content: bytes, message: str, sweep: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (sweep / "0" / name).write_bytes(content)
    assert main(["summarize", f"sweep={sweep}", f"hydra.run.dir={tmp_path / 'summary'}"]) == 2
    told = capsys.readouterr().err
    assert str(sweep / "0") in told
    assert message in told
