"""How often contexts were drawn, pooled over the runs of a pretended sweep."""

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
from html_pages import text, traces, values
from written_runs import train_report, write_run

from dr_lab.__main__ import main
from dr_lab.errors import ConfigError, DataError
from dr_lab.summaries.groups import grouped
from dr_lab.summaries.runs import find_runs
from dr_lab.summaries.sampling import Sampling, SamplingSettings, samplings
from dr_lab.summaries.sampling_tables import sampling_section

LOW, HIGH = 0.0, 1.0
Drawn = Sequence[tuple[int, float]]


def drew(
    folder: Path, drawn: Drawn, *overrides: str, span: tuple[float, float] = (LOW, HIGH), outside: float = 0.0
) -> None:
    """A training that drew some masses, each after so many control steps, uniform in a range when it began.

    A density that is nowhere zero has a little left outside of that range.
    """
    edges, share = [LOW, *span, HIGH], [outside, 1.0 - 2 * outside, outside]
    inside = {"edges": edges, "initial": share, "probability": share}
    report = train_report(1.0, {"mass": {"unit": "kg", "std": 0.1, **inside}}) | {"frames": 240}
    write_run(folder, report, *overrides)
    rows = ["frames,mass", *(f"{frames},{value!r}" for frames, value in drawn), ""]
    (folder / "contexts.csv").write_text("\n".join(rows), "utf-8")


def found_in(folder: Path, block: int = 100, bins: int = 2) -> list[Sampling]:
    """What is found of the mass."""
    return samplings(grouped(find_runs(folder)[0], ["seed"]), SamplingSettings(block, bins)).get("mass", [])


def evenly(count: int) -> list[float]:
    return ((np.arange(count) + 0.5) / count).tolist()


def test_runs_are_pooled_block_by_block(tmp_path: Path) -> None:
    drew(tmp_path / "0", [(0, 0.2), (99, 0.7), (100, 0.9), (210, 1.0)], "learner=adr", "seed=0")
    drew(tmp_path / "1", [(50, 0.1), (150, 0.8), (199, 0.6)], "learner=adr", "seed=1")
    drew(tmp_path / "2", [(0, 0.3), (20, 0.0)], "learner=none", "seed=0")
    adr, none = (each.sampled for each in found_in(tmp_path))
    assert (adr.group, adr.runs, adr.unit) == ("adr", 2, "kg")
    assert adr.count.tolist() == [[2, 1], [0, 4]]
    assert adr.frames.tolist() == [0, 100, 240]  # 40 are less than half a block
    assert adr.edges.tolist() == none.edges.tolist() == [0.0, 0.5, 1.0]
    np.testing.assert_allclose(adr.share, [[2 / 3, 1 / 3], [0, 1]])
    assert none.count.tolist() == [[2, 0], [0, 0]]
    assert np.isnan(none.share[1]).all()  # it drew nothing later


def test_each_group_is_judged_in_the_range_that_it_began_with(tmp_path: Path) -> None:
    for seed in range(2):
        drew(tmp_path / f"{seed}", [*enumerate(evenly(40))], "learner=none", f"seed={seed}")
        narrow = [(k, 0.25 + z / 4) for k, z in enumerate(evenly(40))]
        drew(tmp_path / f"{10 + seed}", narrow, "learner=oracle", f"seed={seed}", span=(0.25, 0.5), outside=1e-9)
        low = [(k, z / 2) for k, z in enumerate(evenly(40))]
        drew(tmp_path / f"{20 + seed}", low, "learner=adr", f"seed={seed}")
    none, oracle, adr = found_in(tmp_path, block=1000)
    assert (none.low, none.high) == (LOW, HIGH)
    assert 0.25 <= oracle.low < oracle.high <= 0.5
    judged = [each.uniformity for each in (none, oracle, adr)]
    assert [each and each.chi2 for each in judged] == [0.0, 0.0, 80.0]  # all 80 draws in one of two bins: 2 · 40²/40
    assert oracle.sampled.count.tolist() == [[80, 0]]


@pytest.mark.parametrize("high", [0.3, 0.7])  # in single precision the one is larger, the other smaller
def test_draws_at_the_ends_of_the_range_are_in_it(tmp_path: Path, high: float) -> None:
    """Batches hold contexts in single precision; walks that are cut off at the bounds are often just there."""
    z = [float(np.float32(value)) for value in [0.1] * 10 + [0.15] * 10 + [high] * 20]
    drew(tmp_path / "0", [*enumerate(z)], "learner=adr", span=(0.1, high))
    (found,) = found_in(tmp_path, block=1000)
    assert found.inside == 40
    assert found.uniformity is not None
    assert found.uniformity.chi2 == 0.0


def test_what_is_not_varied_or_noted_is_not_drawn(tmp_path: Path) -> None:
    drew(tmp_path / "0", [(0, 0.5)], "randomizer=fixed")
    drew(tmp_path / "1", [], "randomizer=none")
    write_run(tmp_path / "2", train_report(1.0, {}), "randomizer=old")
    assert found_in(tmp_path) == []


def test_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    drew(tmp_path / "0", [(0, 0.5)], "seed=0")
    (tmp_path / "0/contexts.csv").write_text("frames,mass\n0,heavy\n", "utf-8")
    with pytest.raises(DataError, match=r"0/contexts\.csv: .*heavy"):
        found_in(tmp_path)
    with pytest.raises(ConfigError, match=r"sampling\.bins is 1"):
        SamplingSettings(block=10, bins=1)


@pytest.mark.parametrize("count", [7, 23, 30, 51, 90])
def test_what_is_advised_of_few_draws_is_enough(tmp_path: Path, count: int) -> None:
    """Most are drawn early, and some out of the range in which they are judged."""
    z = [*np.linspace(0.0, 0.5, count).tolist(), 0.9, 0.95, 1.0]
    drew(tmp_path / "0", [*enumerate(z)], "learner=none", span=(0.0, 0.5))
    settings = SamplingSettings(block=3, bins=5)
    found = samplings(grouped(find_runs(tmp_path)[0], ["seed"]), settings)
    assert found["mass"][0].uniformity is None
    advised = {
        name: int(value) for name, value in re.findall(r"sampling\.(\w+)=(\d+)", sampling_section(found, settings).body)
    }
    if count < 10:
        assert not advised
        assert "drew 7 values in the range; train longer" in sampling_section(found, settings).body
        return
    followed = replace(settings, **advised)
    assert samplings(grouped(find_runs(tmp_path)[0], ["seed"]), followed)["mass"][0].uniformity is not None


def test_the_verb_tells_and_draws_it(tmp_path: Path) -> None:
    for seed in range(2):
        drew(tmp_path / f"sweep/{seed}", [(k, z) for k, z in enumerate(evenly(30))], "learner=none", f"seed={seed}")
        high = [(k, 0.5 + z / 2) for k, z in enumerate(evenly(30))]
        drew(tmp_path / f"sweep/{10 + seed}", high, "learner=adr", f"seed={seed}")
    folder = tmp_path / "summary"
    typed = ["sampling.block=1000", "sampling.bins=2", "figures={dr_lab/train/1:[final_return]}"]
    assert main(["summarize", f"sweep={tmp_path / 'sweep'}", f"hydra.run.dir={folder}", *typed]) == 0
    page = (folder / "report.md").read_text("utf-8")
    assert "## Sampling frequency" in page
    assert "| mass [kg] | none | 2 | 60 | 0 … 1 | 0 | 1 |" in page
    assert "| mass [kg] | adr | 2 | 60 | 0 … 1 | 60 |" in page
    entries = json.loads((folder / "report.json").read_text("utf-8"))["sampling"]
    assert [(entry["group"], entry["count"], entry["dof"]) for entry in entries] == [
        ("none", [[30, 30]], 1),
        ("adr", [[0, 60]], 1),
    ]
    assert "in blocks of about" in (folder / "report.md").read_text("utf-8")
    written = (folder / "report.html").read_text("utf-8")
    assert "adr: 60 draws of 2 runs together, by blocks of 240 control steps. Uniform would be 50 % a bin." in text(
        written
    )
    maps = [trace for name in ("none", "adr") for trace in traces(written, name) if trace["type"] == "heatmap"]
    assert [values(each["z"]).tolist() for each in maps] == [[[0.5], [0.5]], [[0.0], [1.0]]]
    assert {each["zmax"] for each in maps} == {1.0}  # one scale for both
    entities = {str(chunk.entity_path) for chunk in rr.chunk.RrdReader(folder / "review.rrd").stream()}
    assert {path.split("/")[3] for path in entities if path.startswith("/sampled/mass/")} == {"none", "adr"}
