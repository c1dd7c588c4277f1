"""Maps of a sweep in its recording, and curves of one point."""

from pathlib import Path

import numpy as np
import pytest
from recorder_samples import Entities, read_recording

from dr_lab.recorders.heat_map import pixels
from dr_lab.recorders.interference import Interference
from dr_lab.recorders.look import Look
from dr_lab.recorders.sampling import Sampled
from dr_lab.recorders.sweep_review import SweepRecord, write_sweep_review
from dr_lab.recorders.training import Band, ContextAxis

EDGES, FRAMES = np.array([3.0, 6.0, 9.0]), np.array([0, 1000, 2000, 4000])
COUNT = np.array([[1, 3], [0, 0], [2, 0]])


@pytest.fixture
def found(tmp_path: Path, look: Look, monkeypatch: pytest.MonkeyPatch) -> Entities:
    monkeypatch.setenv("RERUN_STRICT", "1")
    sampled = Sampled("adr", "torso.mass", "kg", 3, FRAMES, EDGES, COUNT)
    cosine = np.array([[1.0, -0.5], [-0.5, 1.0]])
    axis = ContextAxis("torso.mass", "kg", np.array([3.0, 9.0]))
    gradients = Interference("adr", 3, 4000, axis, cosine, np.zeros((2, 2)), cosine < 0.0)
    nan = np.full(2, np.nan)
    alone = Band("adr", "loss", np.array([1000, 2000]), np.array([np.nan, 7.0]), nan, nan)
    record = SweepRecord("s", ["adr"], [alone], sampled={"torso.mass": [sampled]}, interference=[gradients])
    write_sweep_review(tmp_path / "review.rrd", record, look)
    return read_recording(tmp_path / "review.rrd")


def test_shares_are_drawn_where_their_blocks_and_bins_lie(found: Entities, look: Look) -> None:
    rows, columns = pixels()
    picture = np.array(found["/sampled/torso.mass/adr/map"]["Image:buffer"][0], np.uint8).reshape(rows, columns, 3)
    above, below = picture[rows // 4], picture[3 * rows // 4]
    fixed, ground, full = (list(look.colour(name)[:3]) for name in ("fixed", "ground", "measured"))
    quarter, middle = columns // 4, columns // 2
    assert (above[: quarter - 1] != below[: quarter - 1]).any(axis=1).all()  # ¾ above 6 kg, ¼ below
    assert (picture[:, quarter + 1 : middle - 1] == ground).all()  # nothing was drawn
    assert (above[middle + 1 :] == fixed).all()
    assert (below[middle + 1 :] == full).all()
    assert found["/sampled/torso.mass/adr/titles"]["Points2D:labels"][-1] == ["control steps", "torso.mass [kg]"]


def test_gradients_of_contexts_mark_what_is_in_doubt(found: Entities) -> None:
    places = [name for name in found if name.startswith("/matrix/") and name.endswith("/doubtful")]
    assert len(places) == 1
    assert len(found[places[0]]["Points2D:positions"][-1]) == 2


def test_one_point_alone_is_a_dot(found: Entities) -> None:
    curve = found["/curve/loss/adr"]
    assert any(key.startswith("SeriesPoints") for key in curve)
    assert not any(key.startswith("SeriesLines") for key in curve)
