import copy
import dataclasses
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import rerun.blueprint as rrb
from hydra.utils import instantiate
from omegaconf import OmegaConf
from recorder_samples import read_recording

from dr_lab.errors import ConfigError, DataError, DrLabError
from dr_lab.recorders.blueprints import review_blueprint, worst_channels
from dr_lab.recorders.force_map import ForceMap
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import Overlay
from dr_lab.recorders.review import write_review
from dr_lab.recorders.signals import residual
from dr_lab.recorders.training import ContextAxis
from dr_lab.reports.gap import GapReport
from dr_lab.reports.markdown import report_markdown
from dr_lab.reports.plain import from_plain
from dr_lab.trajectory import Signal

_LOG = "/swing\\:2"


def gap(report: dict[str, Any]) -> GapReport:
    return from_plain(GapReport, report)


@pytest.fixture(autouse=True)
def _strict(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")


def test_close_recording_has_everything_on_its_clock(
    tmp_path: Path, close_report: dict[str, Any], overlay: Overlay, furuta: mujoco.MjModel, look: Look
) -> None:
    path = tmp_path / "review.rrd"
    write_review(path, gap(close_report), report_markdown(gap(close_report)), [overlay], furuta, look)
    found = read_recording(path)
    for part in ("world/real/pole", "world/sim_before/pole", "world/sim_after/pole"):
        assert {f"{_LOG}/{part}/rod_2", f"{_LOG}/{part}/geom_5"} < found.keys(), part
        frames = found[f"{_LOG}/{part}"]
        assert len(frames["t"]) == 300  # 6 s at 50 Hz, from 500 Hz
        np.testing.assert_allclose(np.diff(frames["t"]), 0.02)
    for channel in overlay.measured:
        for role in ("measured", "sim_before", "sim_after"):
            values = np.array(found[f"{_LOG}/signal/{channel}/{role}"]["Scalars:scalars"]).ravel()
            assert len(values) == 3000
        after = np.array(found[f"{_LOG}/residual/{channel}/sim_after"]["Scalars:scalars"], dtype=float).ravel()
        expected = overlay.measured[channel].value - overlay.simulated["after"][channel]
        np.testing.assert_allclose(after, expected)
        assert np.isnan(after).sum() == 6
        band = found[f"{_LOG}/residual/{channel}/noise"]["Measurements:variances"]
        assert np.ravel(band) == pytest.approx(overlay.noise[channel] ** 2)
    for entity in ("command/motor", "scatter/arm/before", "scatter/pole/after_mean"):
        assert f"{_LOG}/{entity}" in found
    assert {"/verdict", "/report", "/diagnosis/ranking/row_05_bar", "/diagnosis/ladder/row_02_label"} < found.keys()
    assert found["/report"]["TextDocument:text"][0][0] == report_markdown(gap(close_report))


@pytest.mark.parametrize(("verdict", "role"), [("named", "after"), ("unexplained", "noise")])
def test_the_best_effect_has_the_colour_of_what_the_verdict_says(
    tmp_path: Path, close_report: dict[str, Any], furuta: mujoco.MjModel, look: Look, verdict: str, role: str
) -> None:
    write_review(tmp_path / "a.rrd", gap(close_report | {"verdict": verdict}), "", [], furuta, look)
    best = read_recording(tmp_path / "a.rrd")["/diagnosis/ranking/row_00_dot"]
    red, green, blue, alpha = look.colour(role)
    assert np.ravel(best["Points2D:colors"]).tolist() == [red << 24 | green << 16 | blue << 8 | alpha]


def test_an_interval_lies_above_its_bar(
    tmp_path: Path, close_report: dict[str, Any], furuta: mujoco.MjModel, look: Look
) -> None:
    write_review(tmp_path / "a.rrd", gap(close_report), "", [], furuta, look)
    found = read_recording(tmp_path / "a.rrd")
    layers = {p: found[f"/diagnosis/ranking/row_00_{p}"]["LineStrips2D:draw_order"] for p in ("bar", "interval")}
    assert np.ravel(layers["interval"]) > np.ravel(layers["bar"])


def test_a_learned_force_and_the_windows_are_in_the_recording(
    tmp_path: Path, close_report: dict[str, Any], overlay: Overlay, furuta: mujoco.MjModel, look: Look
) -> None:
    position, velocity = (ContextAxis(name, "1", np.array([0.0, 1.0])) for name in ("position", "velocity"))
    shown = ForceMap("N·m", position, velocity, np.eye(2), np.array([[0.5, 0.2]]))
    cut = dataclasses.replace(overlay, force_maps={"arm": shown}, starts=np.arange(6.0))
    write_review(tmp_path / "a.rrd", gap(close_report), "", [cut], furuta, look)
    found = read_recording(tmp_path / "a.rrd")
    assert len(found[f"{_LOG}/force/arm/states"]["Points2D:positions"][-1]) == 1
    after = np.array(found[f"{_LOG}/residual/arm.position/sim_after"]["Scalars:scalars"], dtype=float).ravel()
    assert len(after) == 3000 + 5  # a gap before each start but the first
    assert len(found[f"{_LOG}/signal/arm.position/measured"]["t"]) == 3000


def test_held_commands_last_until_the_end_of_the_log(
    tmp_path: Path, close_report: dict[str, Any], overlay: Overlay, furuta: mujoco.MjModel, look: Look
) -> None:
    short = Signal("motor", "V", np.array([0.0, 1.0]), np.array([0.5, 2.0]))
    write_review(
        tmp_path / "a.rrd",
        gap(close_report),
        "",
        [dataclasses.replace(overlay, commands={"motor": short})],
        furuta,
        look,
    )
    command = read_recording(tmp_path / "a.rrd")[f"{_LOG}/command/motor"]
    assert np.ravel(command["Scalars:scalars"]).tolist() == [0.5, 2.0, 2.0]
    assert command["t"][-1] == pytest.approx(overlay.span()[1])


def test_compare_has_no_after_and_no_ranking(
    tmp_path: Path, compare_report: dict[str, Any], overlay: Overlay, furuta: mujoco.MjModel, look: Look
) -> None:
    def before_only(roles: Any) -> dict:  # noqa: ANN401
        return {role: value for role, value in roles.items() if role != "after"}

    joints = {joint: (v, before_only(roles)) for joint, (v, roles) in overlay.residual_velocity.items()}
    compared = dataclasses.replace(
        overlay, poses=before_only(overlay.poses), simulated=before_only(overlay.simulated), residual_velocity=joints
    )
    write_review(
        tmp_path / "a.rrd", gap(compare_report), report_markdown(gap(compare_report)), [compared], furuta, look
    )
    found = read_recording(tmp_path / "a.rrd")
    assert f"{_LOG}/scatter/arm/before" in found
    assert not [path for path in found if "after" in path or "diagnosis" in path]


@pytest.mark.parametrize(("shapes", "robots"), [(True, 2), (False, 0)])
def test_a_machine_without_shapes_leaves_its_place_to_the_plots(
    close_report: dict[str, Any], overlay: Overlay, furuta: mujoco.MjModel, look: Look, *, shapes: bool, robots: int
) -> None:
    seen = copy.copy(furuta)
    seen.geom_rgba[seen.geom_bodyid > 0, 3] *= shapes
    layout = review_blueprint(gap(close_report), [overlay], seen, look)
    assert [type(view) for view in _views(layout.root_container)].count(rrb.Spatial3DView) == robots


def _views(part: Any) -> Iterator[Any]:  # noqa: ANN401 (containers and views)
    yield from (view for each in part.contents for view in _views(each)) if isinstance(part, rrb.Container) else [part]


def test_two_logs_lie_side_by_side_and_none_is_a_report(
    tmp_path: Path, close_report: dict[str, Any], overlay: Overlay, furuta: mujoco.MjModel, look: Look
) -> None:
    second = dataclasses.replace(overlay, log="other log/1", poses={}, residual_velocity={}, commands={})
    write_review(tmp_path / "two.rrd", gap(close_report), "", [overlay, second], furuta, look)
    found = read_recording(tmp_path / "two.rrd")
    assert "/other\\ log\\/1/signal/arm.position/measured" in found
    assert f"{_LOG}/signal/arm.position/measured" in found
    write_review(tmp_path / "none.rrd", gap(close_report), "# text", [], furuta, look)
    assert "/report" in read_recording(tmp_path / "none.rrd")


def test_failure_leaves_no_file(
    tmp_path: Path, close_report: dict[str, Any], overlay: Overlay, furuta: mujoco.MjModel, look: Look
) -> None:
    close_report["ranking"][0]["gain_ci"] = []
    with pytest.raises(IndexError, match="out of range"):
        write_review(tmp_path / "a.rrd", gap(close_report), "", [overlay], furuta, look)
    assert os.listdir(tmp_path) == []
    (tmp_path / "file").touch()
    with pytest.raises(DrLabError, match="Cannot write"):
        write_review(tmp_path / "file" / "a.rrd", gap(close_report), "", [overlay], furuta, look)


def test_residual_of_an_orientation_is_the_turn_between_them() -> None:
    half = np.deg2rad([0.0, 30.0, 90.0]) / 2
    measured = np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=-1)
    simulated = np.tile([-1.0, 0.0, 0.0, 0.0], (3, 1))  # the same orientation as +1
    simulated[2] = np.nan
    turn = residual(measured, simulated)
    np.testing.assert_allclose(turn[:2], [[0, 0, 0], [0, 0, np.deg2rad(30)]], atol=1e-12)
    assert np.isnan(turn[2]).all()
    np.testing.assert_allclose(residual(np.ones((2, 3)), np.zeros((2, 3))), np.ones((2, 3)))


def test_overview_shows_the_worst_positions(overlay: Overlay) -> None:
    signals = {
        name: Signal(name, "rad", overlay.time, np.sin(overlay.time))
        for name in ("a.velocity", "b.position", "c.position", "d.position")
    }
    misfit = {"a.velocity": 9.0, "b.position": 0.2, "c.position": 0.1, "d.position": 0.3}
    before = {name: signals[name].value + offset for name, offset in misfit.items()}
    before["b.position"][:10] = np.nan
    many = dataclasses.replace(overlay, measured=signals, simulated={"before": before})
    assert worst_channels(many, 2) == ["b.position", "d.position"]
    assert worst_channels(dataclasses.replace(many, simulated={}), 3) == ["b.position", "c.position", "d.position"]


def test_wrong_shapes_and_colours_are_named(overlay: Overlay, look: Look) -> None:
    with pytest.raises(
        DataError, match=r"simulated\['before'\]\['arm.position'\] has shape \(3,\), expected \(3000,\)"
    ):
        dataclasses.replace(overlay, simulated={"before": {"arm.position": np.zeros(3)}})
    with pytest.raises(DataError, match=r"poses\['measured'\] orientations"):
        dataclasses.replace(overlay, poses={"measured": (np.zeros((3000, 3, 3)), np.zeros((3000, 3, 3)))})
    with pytest.raises(DataError, match=r"residual_velocity\['arm'\]\['after'\]"):
        dataclasses.replace(overlay, residual_velocity={"arm": (np.zeros(4), {"after": np.zeros(5)})})
    with pytest.raises(ConfigError, match=r"recorder\.colours\.after is 'blue'"):
        dataclasses.replace(look, colours={**look.colours, "after": "blue"})


def test_every_look_of_the_configuration_is_one() -> None:
    for path in (Path(__file__).parents[3] / "conf" / "recorder").glob("*.yaml"):
        assert isinstance(instantiate(OmegaConf.load(path), _convert_="all"), Look)
