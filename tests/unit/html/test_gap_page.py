import dataclasses
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from html_pages import figures, require_whole, text, traces, values

from dr_lab.html.gap_page import write_gap_page
from dr_lab.recorders.force_map import ForceMap
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import Overlay
from dr_lab.recorders.training import ContextAxis
from dr_lab.reports.gap import GapReport
from dr_lab.reports.plain import from_plain
from dr_lab.reports.quantity import percent
from dr_lab.reports.rankings import by_gain
from dr_lab.trajectory import Signal

LARGEST = 6_000_000  # bytes


@pytest.fixture
def written(tmp_path: Path, close_report: dict[str, Any], overlay: Overlay, look: Look) -> str:
    (velocity, _), path = overlay.residual_velocity["arm"], tmp_path / "report.html"
    arguments = {"arm": {"velocity of arm [rad/s]": velocity, "command motor [V]": np.zeros_like(velocity)}}
    close_report["ladder"][1]["converged"] = True
    close_report["ladder"][1] |= {"fit": {"converged": True, "iterations": 3, "windows": 66, "infeasible_windows": 0}}
    (tmp_path / "next_experiment.csv").write_text("time_s,motor\n0,1.5\n0.5,-2\n", "utf-8")
    report = from_plain(GapReport, close_report)
    write_gap_page(path, report, [dataclasses.replace(overlay, arguments=arguments)], look)
    return path.read_text("utf-8")


def test_the_page_is_whole_and_small(written: str) -> None:
    require_whole(written)
    assert len(written) < LARGEST


def test_the_answer_stands_first(written: str) -> None:
    said = text(written)
    first = said.index("The missing effect is named: coulomb_friction@arm")
    assert first < said.index("Ladder of models") < said.index("Next experiment") < said.index("Noise floor")
    assert "separates coulomb_friction@arm from stribeck_friction@arm by 9.1 σ" in said


def test_the_ladder_ends_at_each_models_chi2(written: str) -> None:
    ladder = next(each for each in figures(written) if "noise floor" in str(each["layout"].get("xaxis", {})))
    ends = {trace["y"][1]: trace["x"][1] for trace in ladder["data"]}
    assert ends == {"model as given": 355.0, "calibrated": 213.4, "+ coulomb_friction@arm": 1.003}


def test_curves_are_the_measured_and_simulated_ones(written: str, overlay: Overlay) -> None:
    signal = overlay.measured["arm.position"]
    for role, value in {
        "measured": signal.value,
        **{r: v["arm.position"] for r, v in overlay.simulated.items()},
    }.items():
        drawn = traces(written, role)[0]
        at = np.searchsorted(signal.time, values(drawn["x"]))
        np.testing.assert_allclose(values(drawn["y"]), value[at], rtol=1e-6)
        assert np.nanmax(values(drawn["y"])) == pytest.approx(np.nanmax(value), rel=1e-6)


def test_the_fit_beside_curves_is_that_of_the_curves(written: str, overlay: Overlay) -> None:
    """Not the report's, whose starts are fitted: in the picture they are measured."""
    measured = overlay.measured["arm.position"].value
    told = []
    for role in ("before", "after"):
        simulated = overlay.simulated[role]["arm.position"]
        known = np.isfinite(simulated)
        nrmse = np.std(measured[known] - simulated[known]) / np.std(measured[known])
        bias = np.mean(measured[known] - simulated[known]) / np.std(measured[known])
        told.append(percent(1.0 - float(np.hypot(nrmse, bias))))
    assert f"arm.position [rad] · fit {' → '.join(told)}" in written
    assert told != ["71 %", "99 %"]  # what the report has


def test_the_autocorrelation_of_a_residual_begins_at_one(written: str) -> None:
    plots = [each for each in figures(written) if "autocorrelation" in str(each["layout"])]
    assert len(plots) == 2
    before, after = (values(trace["y"]) for trace in plots[0]["data"][:2])
    assert (before[0], after[0]) == (1.0, 1.0)
    assert before[5] > 0.9  # friction that is missing
    assert after[5] < 0.5  # noise, and starts that are a little off


def test_candidates_stand_by_what_the_column_shows(close_report: dict[str, Any]) -> None:
    rows = list(from_plain(GapReport, close_report).judged.ranking)
    unfitted = dataclasses.replace(rows[0], effect="backlash", fitted=False, gain=0.0, predicted_gain=0.5)
    gains = [row.gain for row in by_gain([unfitted, *reversed(rows)])]
    assert gains == [0.953, 0.931, 0.41, 0.12, 0.02, -0.01, 0.0]
    assert by_gain([unfitted, *rows])[-1] is unfitted


def test_every_rung_has_its_ranking_and_what_was_not_fitted_no_gain(
    tmp_path: Path, close_report: dict[str, Any], look: Look
) -> None:
    ranking = close_report["ranking"]
    ranking[3] |= {"fitted": False, "gain": 0.0, "gain_ci": [0.0, 0.0], "predicted_gain": 0.3, "status": "rejected"}
    close_report["rungs"][0] |= {"ranking": ranking, "effects": []}
    close_report["rungs"][1] |= {"ranking": ranking[1:], "effects": ["coulomb_friction@arm"]}
    write_gap_page(tmp_path / "report.html", from_plain(GapReport, close_report), [], look)
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "Calibrated model: named" in page
    assert "Model with coulomb_friction@arm: none" in page
    gains = [
        {y: x for t in f["data"] for x, y in zip(t["x"], t["y"], strict=False)}
        for f in figures(page)
        if "removed" in str(f)
    ]
    assert len(gains) == 2
    assert gains[0]["coulomb_friction@arm"] == pytest.approx(95.3)
    assert "coulomb_friction@arm" not in gains[1]
    assert gains[0]["actuator_delay@motor"] == 30.0
    assert all(t["marker"]["symbol"] == "diamond-open" for t in traces(page, "not fitted: what it promised"))


def test_candidates_that_were_not_fitted_stand_in_two_halves_and_keep_their_places(
    tmp_path: Path, close_report: dict[str, Any], look: Look
) -> None:
    for index, row in enumerate(close_report["ranking"][2:], start=3):
        row.update(fitted=False, predicted_gain=0.01 * index, status="rejected")
    write_gap_page(tmp_path / "report.html", from_plain(GapReport, close_report), [], look)
    tables = re.findall(r"<thead>.*?</tbody>", (tmp_path / "report.html").read_text("utf-8"), re.S)
    rows = [re.findall(r">(\d+)</td>\s*<td[^>]*><code>(\w+)@", each) for each in tables if "status" in each]
    assert rows[0] == [("1", "coulomb_friction"), ("2", "stribeck_friction")]
    assert rows[1:] == [[("3", "base_tilt"), ("4", "payload")], [("5", "actuator_delay"), ("6", "quadratic_drag")]]
    assert any("≈ 6.0\u00a0%" in each for each in tables)


def test_many_parameters_stand_in_several_figures(tmp_path: Path, close_report: dict[str, Any], look: Look) -> None:
    last = close_report["ladder"][1]
    last |= {"converged": True, "fit": {"converged": True, "iterations": 3, "windows": 66, "infeasible_windows": 0}}
    last["parameters"] = {f"link_{k}.mass": {"value": 0.1 + k, "std": 0.01, "unit": "kg"} for k in range(50)}
    write_gap_page(tmp_path / "report.html", from_plain(GapReport, close_report), [], look)
    drawn = figures((tmp_path / "report.html").read_text("utf-8"))
    fitted = [[trace["x"][0] for trace in each["data"] if trace.get("name") == "fitted"] for each in drawn]
    assert [len(each) for each in fitted if each] == [24, 24, 2]
    assert [x for each in fitted for x in each] == [0.1 + k for k in range(50)]


def test_the_next_experiment_is_the_command_file(written: str) -> None:
    (command,) = [
        trace for trace in traces(written, "motor") if trace["line"]["shape"] == "hv" and len(values(trace["x"])) == 2
    ]
    assert (values(command["x"]).tolist(), values(command["y"]).tolist()) == ([0.0, 0.5], [1.5, -2.0])


def test_a_parameter_has_its_interval(written: str) -> None:
    torque = next(t for t in traces(written, "fitted") if "N·m" in t["text"][0])
    assert torque["x"] == [0.0020031]
    assert torque["error_x"]["array"] == [2 * 1.04e-5]


def test_a_diamond_is_explained(tmp_path: Path, close_report: dict[str, Any], look: Look) -> None:
    last = close_report["ladder"][1]
    last |= {"converged": True, "fit": {"converged": True, "iterations": 3, "windows": 66, "infeasible_windows": 0}}
    for at_bound in (False, True):
        last["parameters"] = {"link.mass": {"value": 0.1, "std": 0.01, "unit": "kg", "at_bound": at_bound}}
        write_gap_page(tmp_path / "report.html", from_plain(GapReport, close_report), [], look)
        assert ("Diamonds: at a bound." in text((tmp_path / "report.html").read_text("utf-8"))) == at_bound


def test_a_row_of_a_ranking_has_its_dot_in_the_plot(tmp_path: Path, close_report: dict[str, Any], look: Look) -> None:
    close_report["ranking"][-1] |= {"gain": -0.6, "gain_ci": [-0.9, -0.3]}
    write_gap_page(tmp_path / "report.html", from_plain(GapReport, close_report), [], look)
    page = (tmp_path / "report.html").read_text("utf-8")
    plot = next(f for f in figures(page) if "removed" in str(f["layout"]["xaxis"].get("title")))
    low, _ = plot["layout"]["xaxis"]["range"]
    drawn = [(y, x) for trace in plot["data"] for y, x in zip(trace["y"], trace["x"], strict=True)]
    assert sorted(plot["layout"]["yaxis"]["categoryarray"]) == sorted(y for y, _ in drawn)
    assert min(x for _, x in drawn) >= low
    assert "The table has 1 more." in text(page)


def test_words_of_the_legend_of_a_ranking_have_a_look_each(written: str) -> None:
    named = {"named", "rejected", "not excited"}
    looks = {
        t["name"]: (t["marker"]["color"], t["marker"].get("symbol")) for name in named for t in traces(written, name)
    }
    assert looks.keys() == named
    assert len(set(looks.values())) == len(named)


def test_the_noise_is_seen_where_nothing_else_is_left(written: str, overlay: Overlay) -> None:
    drawn = [t for each in figures(written) for t in each["data"] if t.get("line", {}).get("dash") == "dot"]
    edges = [values(t["y"]).tolist() for t in drawn if t.get("legendgroup") == "noise"]
    assert edges == [[edge, edge] for std in overlay.noise.values() for edge in (-std, std)]


def test_one_model_alone_is_simulated_and_has_no_ladder(
    tmp_path: Path, compare_report: dict[str, Any], overlay: Overlay, look: Look
) -> None:
    alone = dataclasses.replace(overlay, simulated={"before": overlay.simulated["before"]})
    write_gap_page(tmp_path / "report.html", from_plain(GapReport, compare_report), [alone], look)
    page = (tmp_path / "report.html").read_text("utf-8")
    require_whole(page)
    assert traces(page, "simulated")
    assert not traces(page, "after")
    assert "removed [%]" not in page
    horizons = next(each for each in figures(page) if "predicted for" in str(each["layout"]))
    np.testing.assert_allclose(values(horizons["data"][1]["y"]), [4e-5, 6e-3, 0.1])


def test_a_command_holds_to_the_end_of_the_log(
    tmp_path: Path, close_report: dict[str, Any], overlay: Overlay, look: Look
) -> None:
    once = Signal("motor", "V", np.array([0.5]), np.array([3.0]))
    sent = dataclasses.replace(overlay, commands={"motor": once})
    write_gap_page(tmp_path / "report.html", from_plain(GapReport, close_report), [sent], look)
    (trace,) = traces((tmp_path / "report.html").read_text("utf-8"), "motor")
    np.testing.assert_allclose(values(trace["x"]), [0.5, overlay.span()[1]])
    np.testing.assert_allclose(values(trace["y"]), [3.0, 3.0])


def test_commands_of_one_plot_share_a_unit_and_no_colour(
    tmp_path: Path, close_report: dict[str, Any], overlay: Overlay, look: Look
) -> None:
    units = {f"motor_{k}": "V" if k < 9 else "1" for k in range(10)}
    sent = {name: Signal(name, unit, np.array([0.0, 1.0]), np.ones(2)) for name, unit in units.items()}
    shown = dataclasses.replace(overlay, commands=sent)
    write_gap_page(tmp_path / "report.html", from_plain(GapReport, close_report), [shown], look)
    plots = [
        f for f in figures((tmp_path / "report.html").read_text("utf-8")) if "motor_" in f["data"][0].get("name", "")
    ]
    colours = [[trace["line"]["color"] for trace in each["data"]] for each in plots]
    assert [len(each) for each in colours] == [len(set(each)) for each in colours] == [7, 2, 1]
    titles = [each["layout"]["yaxis"]["title"]["text"] for each in plots]
    assert titles == ["command [V]", "command [V]", "command"]


def test_each_joints_force_has_its_own_unit(
    tmp_path: Path, close_report: dict[str, Any], overlay: Overlay, look: Look
) -> None:
    velocity = {joint: {"velocity": overlay.residual_velocity[joint][0]} for joint in ("arm", "pole")}
    names = {"arm": "missing force [N]", "pole": "missing force [N·m]"}
    shown = dataclasses.replace(overlay, arguments=velocity, residual_names=names)
    write_gap_page(tmp_path / "report.html", from_plain(GapReport, close_report), [shown], look)
    titles = [
        str(each["layout"]["yaxis"].get("title")) for each in figures((tmp_path / "report.html").read_text("utf-8"))
    ]
    assert any("arm: missing force [N]" in title for title in titles)
    assert any("pole: missing force [N·m]" in title for title in titles)
    assert "lines: their mean over ranges that hold as many dots each" in (tmp_path / "report.html").read_text("utf-8")


@pytest.mark.slow
def test_many_long_logs_stay_small(tmp_path: Path, close_report: dict[str, Any], look: Look) -> None:
    time, rng = np.linspace(0.0, 60.0, 12_000), np.random.default_rng(0)
    noisy = {
        f"joint_{k}.position": Signal(f"joint_{k}.position", "rad", time, rng.normal(size=12_000)) for k in range(14)
    }
    simulated = {role: {name: 0.9 * s.value for name, s in noisy.items()} for role in ("before", "after")}
    logs = [Overlay(f"log_{k}", time, {}, noisy, simulated, {}, {}, dict.fromkeys(noisy, 0.1)) for k in range(9)]
    write_gap_page(tmp_path / "report.html", from_plain(GapReport, close_report), logs, look)
    page = (tmp_path / "report.html").read_text("utf-8")
    assert len(page) < LARGEST
    assert "Curves are thinned" in page
    assert "It also holds log_" in page


def test_an_orientation_is_drawn_by_its_components(tmp_path: Path, close_report: dict[str, Any], look: Look) -> None:
    time = np.linspace(0.0, 1.0, 101)
    angle = 0.5 * time
    turned = np.stack([np.cos(angle / 2), np.zeros(101), np.zeros(101), np.sin(angle / 2)], axis=1)
    still = np.tile([1.0, 0.0, 0.0, 0.0], (101, 1))
    signal = Signal("box", "1", time, turned)
    overlay = Overlay("log", time, {}, {"box": signal}, {"before": {"box": still}}, {}, {}, {"box": 0.1})
    write_gap_page(tmp_path / "report.html", from_plain(GapReport, close_report), [overlay], look)
    page = (tmp_path / "report.html").read_text("utf-8")
    assert len(traces(page, "measured")) == 4
    assert [trace["showlegend"] for trace in traces(page, "measured")] == [True, False, False, False]
    residuals = [trace for trace in traces(page, "") if trace.get("yaxis") == "y2"]
    np.testing.assert_allclose(values(residuals[2]["y"]), angle, atol=1e-6)  # about z, rad
    assert values(traces(page, "noise ±σ")[0]["y"]).max() == pytest.approx(0.2)  # rad: twice a component's
    assert '"[rad]"' in page
    assert "[1]" not in page


def test_a_learned_force_is_a_map_with_the_place_of_the_log(
    tmp_path: Path, close_report: dict[str, Any], overlay: Overlay, look: Look
) -> None:
    force = np.array([[0.1, np.nan], [-0.3, 0.2]])
    position, velocity = (
        ContextAxis(name, unit, np.array([0.0, 1.0])) for name, unit in (("position", "rad"), ("velocity", "rad/s"))
    )
    shown = ForceMap("N·m", position, velocity, force, np.array([[0.5, 0.2], [0.6, 0.1]]))
    arguments = {joint: {"velocity": speed} for joint, (speed, _) in overlay.residual_velocity.items()}
    learned = dataclasses.replace(overlay, force_maps={"arm": shown}, arguments=arguments)
    write_gap_page(tmp_path / "report.html", from_plain(GapReport, close_report), [learned], look)
    page = (tmp_path / "report.html").read_text("utf-8")
    require_whole(page)
    (drawn,) = traces(page, "learned force")
    np.testing.assert_allclose(values(drawn["z"]), force.T)
    assert (drawn["zmin"], drawn["zmax"]) == (-0.3, 0.3)
    (dots,) = traces(page, "the log")
    np.testing.assert_allclose(values(dots["y"]), [0.2, 0.1])
