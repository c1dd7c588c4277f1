"""The demo from logs to run folder: the right effect, the right numbers, and every file as other tools read it."""

import json
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from PIL import Image
from recorder_samples import Entities, read_recording
from rerun.chunk import McapReader
from rerun.experimental import ViewerClient
from test_model_xml import EXACT, plain
from viewer_pages import require_pages

from dr_lab.recorders.look import Look
from dr_lab.recorders.viewer import screenshot, show
from dr_lab.reports.schema import validate
from dr_lab.trajectory import Array

TRUTH = Path(__file__).parents[2] / "examples" / "furuta" / "truth.yaml"
FILES = {
    *("config.yaml", "report.json", "report.md", "report.html", "metrics.csv", "review.rrd"),
    *("simulated.mcap", "model.xml", "rollout.npz", "context.yaml"),
}
CHANNELS = {"arm.position", "pole.position"}


@pytest.fixture(scope="module")
def report(demo_run: Path) -> dict[str, Any]:
    return json.loads((demo_run / "report.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def truth() -> dict[str, Any]:
    return yaml.safe_load(TRUTH.read_text(encoding="utf-8"))


def test_the_hidden_effect_is_named(report: dict[str, Any], truth: dict[str, Any]) -> None:
    assert report["verdict"] == "named"
    assert report["ladder"][-1]["effects"] == [truth["hidden"]["effect"]]
    assert [row["effect"] for row in report["ranking"] if row["status"] == "named"] == ["coulomb_friction"]
    assert report["remaining"]["status"] == "at_floor"


def test_the_error_falls_to_the_noise_floor(report: dict[str, Any]) -> None:
    calibrated, final = (report["ladder"][i]["held_out"] for i in (0, -1))
    assert report["as_given"]["held_out"]["chi2"] > calibrated["chi2"] >= 10.0
    assert 0.9 <= final["chi2"] <= 1.1
    assert final["chi2_predicted"] <= 2.0  # a start that is known from 0.1 s alone adds to the noise
    for channel in CHANNELS:
        assert final["rmse"][channel] == pytest.approx(report["noise"][channel]["std"], rel=0.1)
        assert final["rmse_predicted"][channel] < 0.1 * calibrated["rmse_predicted"][channel]


def test_the_numbers_are_the_machines(report: dict[str, Any], truth: dict[str, Any]) -> None:
    found = report["ladder"][-1]["parameters"]
    true = truth["parameters"] | {"coulomb_friction@arm.torque": truth["hidden"]["parameters"]["torque"]}
    assert set(found) == set(true)
    for name, value in true.items():
        assert found[name]["value"] == pytest.approx(value, rel=0.01), name
        assert abs(found[name]["value"] - value) < 6 * found[name]["std"] + 5e-3 * value, name


def test_the_report_follows_the_schema(demo_run: Path, report: dict[str, Any]) -> None:
    validate(report)
    assert set(report["noise"]) == CHANNELS
    assert report["run"] == str(demo_run)
    text = (demo_run / "report.md").read_text(encoding="utf-8")
    assert "coulomb_friction@arm" in text
    assert "dr-lab view" in text


def test_the_run_folder_holds_what_it_should_and_nothing_else(demo_run: Path) -> None:
    assert {path.name for path in demo_run.iterdir()} == FILES
    assert all(path.stat().st_size > 0 for path in demo_run.iterdir())
    config = yaml.safe_load((demo_run / "config.yaml").read_text(encoding="utf-8"))
    assert sorted(config["effects"]) == ["actuator_delay", "coulomb_friction", "viscous_friction"]
    assert {"versions", "git"} <= set(config["made_with"])


def test_the_context_is_a_distribution(demo_run: Path, report: dict[str, Any]) -> None:
    context = yaml.safe_load((demo_run / "context.yaml").read_text(encoding="utf-8"))
    found = report["ladder"][-1]["parameters"]
    assert context["names"] == list(found)
    covariance, low, high = (np.array(context[key]) for key in ("covariance", "low", "high"))
    np.testing.assert_array_equal(context["mean"], [entry["value"] for entry in found.values()])
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), context["std"], rtol=1e-12)
    scale = 1.0 / np.array(context["std"])
    correlation = covariance * np.outer(scale, scale)
    np.testing.assert_allclose(correlation, correlation.T, atol=1e-12)
    assert np.linalg.eigvalsh(correlation).min() > 0.0
    assert ((low <= context["mean"]) & (context["mean"] <= high)).all()
    assert ((low <= context["nominal"]) & (context["nominal"] <= high)).all()


def test_the_model_is_plain_mjcf(demo_run: Path, report: dict[str, Any]) -> None:
    model = mujoco.MjModel.from_xml_path(str(demo_run / "model.xml"))
    found = {name: entry["value"] for name, entry in report["ladder"][-1]["parameters"].items()}
    assert model.body("pole").mass[0] == pytest.approx(found["pole.mass"], rel=1e-5)
    assert model.joint("pole").damping[0] == pytest.approx(found["pole.damping"], rel=1e-5)
    assert model.joint("arm").frictionloss[0] == pytest.approx(found["coulomb_friction@arm.torque"], rel=1e-5)


def test_mujoco_alone_repeats_it(demo_run: Path) -> None:
    position, velocity = plain(demo_run)[demo_run.name]
    assert position < EXACT
    assert velocity < 1e3 * EXACT


SHOWN = ("measured", "sim_after")


def curve(entities: Entities, entity: str) -> tuple[Array, Array]:
    """Values of a curve, and their times in s."""
    columns = entities[entity]
    values, times = (np.array(columns[name], dtype=float).ravel() for name in ("Scalars:scalars", "t"))
    return values, times


def test_the_recording_holds_both_logs(demo_run: Path) -> None:
    entities = read_recording(demo_run / "review.rrd")
    for log in ("log_5", "log_6"):
        for robot in ("real", "sim_before", "sim_after"):
            assert f"/{log}/world/{robot}/pole" in entities
        for channel in CHANNELS:
            (measured, when), (values, then) = (curve(entities, f"/{log}/signal/{channel}/{k}") for k in SHOWN)
            shown = np.isfinite(values)  # lines break where a simulation begins anew
            assert len(measured) > 2000
            assert shown.sum() > 0.9 * len(measured)
            assert np.std(np.interp(then[shown], when, measured) - values[shown]) < 0.01
    assert {"/verdict", "/report", "/diagnosis/ranking_table"} <= set(entities)


def test_other_tools_read_the_simulated_logs(demo_run: Path) -> None:
    path = demo_run / "simulated.mcap"
    topics = {channel.topic for channel in McapReader(path).info().channels}
    states = {f"{prefix}/joint_states" for prefix in ("/real", "/sim", "/sim_before", "/residual")}
    assert topics == {*states, "/command"}
    read: dict[str, list[Any]] = {topic: [] for topic in states}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages(topics=sorted(states)):
            read[channel.topic].append(message)
    assert {tuple(m.name) for messages in read.values() for m in messages} == {("arm", "pole")}
    real, after, rest = (
        np.array([m.position for m in read[f"{prefix}/joint_states"]]) for prefix in ("/real", "/sim", "/residual")
    )
    assert len(after) == len(rest) > 0.9 * len(real)
    assert np.sqrt((rest**2).mean()) < 0.002


@pytest.fixture(scope="module")
def apart(demo_run: Path) -> float:
    """Time in s at which the model before is farthest from the measured robot of the first log."""
    residual = read_recording(demo_run / "review.rrd")["/log_5/residual/arm.position/sim_before"]
    size = np.abs(np.array(residual["Scalars:scalars"], dtype=float)).ravel()
    return residual["t"][int(np.nanargmax(size))]


@pytest.mark.viewer
def test_the_recording_opens_without_complaint(viewer: ViewerClient, demo_run: Path, look: Look, apart: float) -> None:
    show(viewer, demo_run / "review.rrd", at=apart)
    measured, before, after, noise = (look.colour(role) for role in ("measured", "before", "after", "noise"))
    joints = ("arm", "pole")
    log = {f"{joint}.position [rad]": [measured, before, after] for joint in joints}
    require_pages(
        viewer,
        {
            "Overview": {
                "measured (white), model before": [measured, before],
                "measured (white), model after": [after],
                **log,
                **{f"{joint}.position, measured": [before, after] for joint in joints},
                "Ladder": [before, after],
            },
            "Signals": {"commands": [look.colour("command")], "after alone": [after], **log},
            "Residual and velocity": {f"{joint}: missing force": [before, after] for joint in joints},
            "Ranking": {"Ranking": [after, noise, measured]},
            "Report": {"Report": []},
        },
    )


@pytest.mark.viewer
@pytest.mark.usefixtures("viewer")
def test_a_picture_of_the_review(demo_run: Path, tmp_path: Path, apart: float) -> None:
    picture = tmp_path / "review.png"
    screenshot(demo_run / "review.rrd", picture, at=apart)
    with Image.open(picture) as image:
        assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 500
