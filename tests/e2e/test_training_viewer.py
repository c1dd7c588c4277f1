"""The recording of a training run in the real viewer: curves, distribution, returns over contexts, episodes."""

import time
from pathlib import Path

import mujoco
import numpy as np
import pytest
from rerun.experimental import ViewerClient
from viewer_pages import count, pages, pixels_of, require_pages

from dr_lab.recorders.branch import ITERATIONS
from dr_lab.recorders.episode import Episode
from dr_lab.recorders.look import Look
from dr_lab.recorders.training import ContextAxis, Curve, Gain, Grid, Marginal, Pair, Ways
from dr_lab.recorders.training_review import TrainingRecord, write_training_review
from dr_lab.recorders.viewer import show

pytestmark = pytest.mark.viewer
ITERATION = np.arange(5)
STEPS, DT = 200, 0.02  # s
AT = 2.0  # s
SCENE = "episode 1: return 100, arm.mass 0.1 kg"


@pytest.fixture
def episode(furuta: mujoco.MjModel) -> Episode:
    """Arm and pole turn evenly."""
    time = DT * np.arange(STEPS + 1, dtype=np.float64)
    turning = np.stack([time, 2.0 * time], axis=1)
    reward = np.linspace(0.0, 1.0, STEPS)
    context = {"arm.mass": (0.1, "kg")}
    action = np.sin(np.arange(STEPS))[:, None] * np.ones(furuta.nu)
    speed = np.tile([1.0, 2.0], (STEPS + 1, 1))
    return Episode("episode_1", context, furuta, time, turning, speed, turning, action, reward, "truncated")


def distributions() -> tuple[Marginal, Pair]:
    share = np.linspace(0.5, 0.9, 5)
    edges = np.array([0.0, 0.1, 0.3])
    marginal = Marginal("size", "m", edges, np.array([0.5, 0.5]), ITERATION, np.stack([share, 1 - share], axis=1))
    mean = np.stack([np.linspace(1.0, 2.0, 5), np.full(5, 0.5)], axis=1)
    covariance = np.tile(np.diag([0.04, 0.01]), (5, 1, 1))
    return marginal, Pair(
        ("friction", "size"), ("1", "m"), np.zeros(2), np.array([4.0, 1.0]), ITERATION, mean, covariance
    )


@pytest.fixture
def recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, look: Look, episode: Episode) -> Path:
    monkeypatch.setenv("RERUN_STRICT", "1")
    marginal, pair = distributions()
    axis = ContextAxis("friction", "1", np.array([0.0, 1.0, 2.0]))
    grids = [
        Grid("line", [axis], np.array([0.0, 1.0, 2.0]), np.zeros(3), "episodes"),
        Grid("area", [axis, axis], np.arange(9.0).reshape(3, 3), np.zeros((3, 3)), "episodes"),
    ]
    curves = [Curve(name, "", ITERATION, np.arange(5.0)) for name in ("return", "entropy")]
    pages = {"Report": "# Report", "Settings": "# Settings"}
    gain = np.linspace(-1.0, 1.0, 9).reshape(3, 3)
    course = np.stack([np.linspace(0.0, 1.0, 9), np.linspace(0.0, 0.5, 9)], axis=1)
    adapted = {
        "gains": [Gain("of 1 update", [axis, axis], gain, gain - 0.1, gain + 0.1)],
        "ways": [Ways("after 1 update", np.array([[1.0, 0.5]]), [-course], [course])],
    }
    path = tmp_path / "review.rrd"
    write_training_review(
        path, TrainingRecord("run", curves, [marginal], [pair], grids, pages, [episode], **adapted), look
    )
    return path


def test_every_page_shows_what_it_says(viewer: ViewerClient, recording: Path, look: Look) -> None:
    show(viewer, recording, AT)
    viewer.set_time(ITERATIONS, sequence=int(ITERATION[-1]))
    learned = look.colour("after")
    expected = {
        "Overview": {"Report": [], "return": [learned], "p(z) of size": [learned]},
        "Curves": {"entropy": [learned]},
        "Learned distribution": {"p(z) of size": [learned]},
        "Pairs of parameters": {"p(z) of friction, size": [learned]},
        "Mean returns": {"returns, line": [learned], "returns, area": [learned]},
        "Adaptation": {
            "gain of 1 update": [learned, look.colour("before")],
            "ways, after 1 update": [learned, look.colour("before")],
        },
        "Episodes (timeline t)": {SCENE: [learned], "Episodes of the trained policy": []},
        "Settings": {"Settings": []},
    }
    require_pages(viewer, expected)


def test_curves_say_their_timeline_where_episodes_have_another(viewer: ViewerClient, recording: Path) -> None:
    show(viewer, recording, AT)
    shown = {view.name for view in viewer.get_state().views if view.name.startswith("return: ")}
    assert shown == {"return: 0 → 4 (timeline iteration)"}


def test_machines_are_there_on_either_timeline(viewer: ViewerClient, recording: Path, look: Look) -> None:
    show(viewer, recording, AT)
    views = next(views for page, views in pages(viewer) if page.startswith("Episodes"))
    for turn in (lambda: None, lambda: viewer.set_time(ITERATIONS, sequence=int(ITERATION[-1]))):
        turn()
        time.sleep(1.0)  # s: until it is drawn
        assert count(pixels_of(viewer, SCENE, views), look.colour("after")) > 50


def test_episodes_alone_have_their_rewards_and_actions(
    viewer: ViewerClient, tmp_path: Path, look: Look, episode: Episode, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")
    write_training_review(
        tmp_path / "review.rrd", TrainingRecord("run", pages={"Report": "# Report"}, episodes=[episode]), look
    )
    show(viewer, tmp_path / "review.rrd", AT)
    views = next(views for page, views in pages(viewer) if page.startswith("Episodes"))
    for view, colour in ((SCENE, "after"), ("reward of each step", "after"), ("action", "after")):
        assert count(pixels_of(viewer, view, views), look.colour(colour)) > 50, view
