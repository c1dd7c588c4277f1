"""The recording of a sweep in the real viewer: every group's colour is where it should be."""

from pathlib import Path

import numpy as np
import pytest
from recorder_samples import read_recording
from rerun.experimental import ViewerClient
from viewer_pages import require_pages

from dr_lab.errors import DrLabError
from dr_lab.recorders.interference import Interference
from dr_lab.recorders.look import Look
from dr_lab.recorders.sampling import Sampled
from dr_lab.recorders.sweep_review import SweepRecord, write_sweep_review
from dr_lab.recorders.training import Band, ContextAxis, Grid, Marginal
from dr_lab.recorders.viewer import show

GROUPS = ("lsdr", "none")
FRAMES = np.arange(1, 6) * 1000
EDGES = np.linspace(0.0, 0.2, 5)
BLOCKS = np.array([0, 500, 1000])
COUNT = np.array([[5, 5, 5, 5], [0, 0, 0, 20]])
COSINES = np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


def band(group: str, name: str, level: float, *, alone: bool = False) -> Band:
    value = level + np.arange(5.0)
    ends = [np.full(5, np.nan)] * 2 if alone else [value - 0.4, value + 0.4]
    return Band(group, name, FRAMES, value, ends[0], ends[1])


def marginal(share: float) -> Marginal:
    learned = np.array([share, 0.5 - share, share, 0.5 - share])
    return Marginal("torso.size", "m", EDGES, np.full(4, 0.25), np.zeros(1, int), learned[None])


@pytest.fixture
def recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, look: Look) -> Path:
    monkeypatch.setenv("RERUN_STRICT", "1")
    axis = ContextAxis("torso.size", "m", np.array([0.0, 0.1, 0.2]))
    grids = {
        group: Grid(group, [axis], np.array([k, 3.0, 1.0 - k]), np.ones(3), "episodes")
        for k, group in enumerate(GROUPS)
    }
    record = SweepRecord(
        "sweep",
        GROUPS,
        [band("lsdr", "return", 0.0), band("none", "return", 3.0, alone=True), band("lsdr", "entropy", 1.0)],
        {"torso.size": {"lsdr": marginal(0.1), "none": marginal(0.3)}},
        grids,
        pages={"Summary": "# Summary", "Runs": "# Runs"},
        sampled={
            "torso.size": [Sampled(g, "torso.size", "m", 3, np.array([0, 500, 1000]), EDGES, COUNT) for g in GROUPS]
        },
        interference=[Interference("lsdr", 3, 1000, axis, COSINES, np.zeros((3, 3)), COSINES == 0.0)],
    )
    path = tmp_path / "review.rrd"
    write_sweep_review(path, record, look)
    return path


def test_curves_carry_their_intervals(recording: Path) -> None:
    found = read_recording(recording)
    both, alone = (np.ravel(list(found[f"/curve/return/{g}"]["Scalars:scalars"])) for g in GROUPS)
    np.testing.assert_array_equal(found["/curve/return/lsdr"]["frames"], FRAMES)
    np.testing.assert_allclose(both, np.arange(5.0))
    np.testing.assert_allclose(alone, 3.0 + np.arange(5.0))
    interval = found["/curve/return/lsdr/interval"]
    np.testing.assert_allclose(np.ravel(list(interval["Measurements:values"])), np.arange(5.0))
    np.testing.assert_allclose(np.ravel(list(interval["Measurements:variances"])), 0.4**2)
    assert "/curve/return/none/interval" not in found


@pytest.mark.viewer
def test_every_page_shows_every_group(viewer: ViewerClient, recording: Path, look: Look) -> None:
    first, second, prior = look.series(0), look.series(1), look.colour("noise")
    show(viewer, recording)
    expected = {
        "Overview": {"return": [first, second], "p(z) of torso.size": [first, second, prior]},
        "Curves": {"return": [first, second], "entropy": [first]},
        "Learned distributions": {"p(z) of torso.size": [first, second]},
        "Returns over contexts": {"returns over torso.size": [first, second]},
        "Sampling frequency": {
            f"share of draws of torso.size, {g} (3 runs)": [look.colour("measured")] for g in GROUPS
        },
        "Gradients of contexts": {"cosine, 1000 steps, lsdr (3 runs)": [look.colour("before"), look.colour("after")]},
        "Runs": {"Runs": []},
    }
    require_pages(viewer, expected)


@pytest.mark.viewer
def test_a_time_in_seconds_is_refused_where_frames_are_counted(viewer: ViewerClient, recording: Path) -> None:
    with pytest.raises(DrLabError, match=r"has no timeline 't', to stop 0.5 s after its start; it has frames. Leave"):
        show(viewer, recording, at=0.5)
