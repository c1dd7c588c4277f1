from dataclasses import replace
from pathlib import Path

import numpy as np
from html_pages import figures, require_whole, text, traces, values

from dr_lab.evaluators.statistics import iqm_interval
from dr_lab.html.sweep_page import comparison_plots, write_sweep_page
from dr_lab.recorders.sweep_review import SweepRecord
from dr_lab.recorders.training import Band, ContextAxis, Grid, Marginal, Sample
from dr_lab.reports.page import Page, Section
from dr_lab.reports.summarize import GroupEntry, SummarizeReport


def test_the_comparison_stands_first_with_its_intervals(tmp_path: Path) -> None:
    figure = {"final_return": {"iqm": 10.0, "low": 8.0, "high": 13.0, "runs": 3.0}, "seconds": {"iqm": 5.0}}
    other = {"final_return": {"iqm": 4.0, "low": None, "high": None, "runs": 1.0}, "seconds": {"iqm": 5.0}}
    groups = (GroupEntry({"learner": "lsdr"}, ("0", "1", "2"), figure), GroupEntry({}, ("3",), other))
    frames = np.array([100, 200, 300])
    nan = np.full(3, np.nan)
    bands = [
        Band("lsdr", "episode_return", frames, np.array([1.0, 2.0, 3.0]), np.zeros(3), np.full(3, 4.0)),
        Band("udr", "episode_return", frames, np.array([1.0, np.nan, 1.0]), nan, nan),
    ]
    marginal = Marginal("size", "m", np.array([0.0, 0.5]), np.ones(1), np.zeros(1, int), np.ones((1, 1)))
    grid = Grid("lsdr", [ContextAxis("size", "m", np.array([0.1, 0.2]))], np.array([1.0, 2.0]), np.ones(2), "episodes")
    record = SweepRecord(
        "s", ["lsdr", "udr"], bands, {"size": {"lsdr": marginal}}, {"lsdr": grid}, pages={"Runs": "| r |"}
    )
    record = replace(record, violins={"udr": [Sample("udr · unseen", np.array([1.0, 2.0]))]})
    report = SummarizeReport("dr_lab/summarize/1", "summarize", "s", groups, (), (), "run")
    page = Page("4 runs of s", "Means.", [Section("figures", "", "| figure |\n|--|\n| final_return |")])
    write_sweep_page(tmp_path / "report.html", page, report, record)
    written = (tmp_path / "report.html").read_text("utf-8")
    require_whole(written)
    first, *others = figures(written)
    assert first["layout"]["xaxis"]["title"]["text"] == "final_return"
    rows = {t["name"]: (t["x"], t["error_x"]["array"], t["error_x"]["arrayminus"]) for t in first["data"]}
    assert rows == {"lsdr": ([10.0], [3.0], [2.0]), "udr": ([4.0], [0.0], [0.0])}
    assert "seconds" not in str(others)  # the same in all groups
    said = text(written)
    assert said.index("Comparison") < said.index("Over training") < said.index("Learned distributions")
    (violin,) = [t for t in traces(written, "udr · unseen") if t["type"] == "violin"]
    assert (values(violin["y"]).tolist(), violin["line"]["color"]) == ([1.0, 2.0], "var(--series-1)")
    curve = next(t for t in traces(written, "udr") if t.get("mode") == "lines+markers")
    assert values(curve["y"]).tolist() == [1.0, 1.0]


def test_axes_have_the_units_of_their_figures() -> None:
    groups = [GroupEntry({}, ("0",), {"context.mass.mean": {"iqm": value}}) for value in (1.0, 2.0)]
    (plot,) = comparison_plots(groups, ["adr", "udr"], {"context.mass.mean": "kg"})
    assert plot.figure.to_dict()["layout"]["xaxis"]["title"]["text"] == "context.mass.mean [kg]"


def test_titles_side_by_side_have_room() -> None:
    def rows(name: str, label: str) -> list[int]:
        figures = [{f"{name}_{k}": {"iqm": float(group + k)} for k in range(4)} for group in range(2)]
        groups = [GroupEntry({}, ("0",), each) for each in figures]
        plots = comparison_plots(groups, [label, "udr"], {})
        return [sum(key.startswith("xaxis") for key in plot.figure.layout.to_plotly_json()) for plot in plots]

    assert rows("return", "adr") == [1, 3]
    assert rows("context.main_engine_power.mean", "lunar_lander_adr_with_a_long_name_of_its_experiment") == [1, 2, 1]


def test_curves_of_one_point_are_told(tmp_path: Path) -> None:
    nan = np.full(2, np.nan)
    bands = [Band("adr", "kl", np.array([100, 200]), np.array([np.nan, 7.5]), nan, nan)]
    report = SummarizeReport("dr_lab/summarize/1", "summarize", "s", (), (), (), "run")
    write_sweep_page(tmp_path / "report.html", Page("Runs", "", []), report, SweepRecord("s", ["adr"], bands))
    said = text((tmp_path / "report.html").read_text("utf-8"))
    assert "Divergence between the policy that acted and the updated one, nat." in said
    assert "adr: one point alone, 7.5 after 200 steps." in said


def test_many_groups_and_figures_stay_small(tmp_path: Path) -> None:
    frames, groups = np.arange(0, 2_000_000, 1000), [f"group {k}" for k in range(24)]
    value = frames / 1e6
    bands = [Band(group, f"figure {k}", frames, value, value - 1, value + 1) for group in groups for k in range(20)]
    report = SummarizeReport("dr_lab/summarize/1", "summarize", "s", (), (), (), "run")
    write_sweep_page(tmp_path / "report.html", Page("Runs", "", []), report, SweepRecord("s", groups, bands))
    written = (tmp_path / "report.html").read_text("utf-8")
    assert len(written) < 6_000_000
    curves = [t for t in traces(written, "group 3") if t["mode"] == "lines"]
    assert len(curves) == 20
    assert values(curves[0]["x"])[[0, -1]].tolist() == frames[[0, -1]].tolist()


def test_two_runs_have_no_interval_and_the_caption_says_so() -> None:
    ends = iqm_interval(np.array([1.0, 2.0]), 0.95, 10, 0)
    assert np.isnan([ends.low, ends.high]).all()
    groups = [GroupEntry({}, ("0", "1"), {"return": {"iqm": value, "low": None, "runs": 2}}) for value in (1.5, 2.0)]
    assert "fewer than three runs has not" in comparison_plots(groups, ["adr", "udr"], {})[0].caption
