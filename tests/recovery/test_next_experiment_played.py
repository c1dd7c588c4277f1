"""Logs that cannot tell two causes apart, the experiment that is proposed, and the answer with its log."""

import json
from pathlib import Path
from typing import Any

import pytest

from dr_lab.__main__ import main

MACHINE = ["plant=pendulum", "plant/hidden=general/constant_offset", "plant.hidden.site=pendulum"]
WEAK = ["plant.hidden.torque=0.08", "plant.peaks=[0.35,0.3,0.32]", "plant.duration=2.5"]
CLOSE = ["model=pendulum", "measurements=pendulum", "effect=[constant_offset,sensor_bias]", "threads=1"]


def closed(*arguments: str) -> dict[str, Any]:
    assert main(["close", *CLOSE, 'measurements.logs=["logs/*.mcap"]', *arguments]) == 0
    folder = next(text.partition("=")[2] for text in arguments if text.startswith("hydra.run.dir"))
    return json.loads((Path(folder) / "report.json").read_text("utf-8"))


@pytest.mark.slow
def test_the_proposed_experiment_decides(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A pendulum that hardly moves shows the same with a constant torque as with a biased encoder."""
    monkeypatch.chdir(tmp_path)
    assert main(["record", *MACHINE, *WEAK, "output=logs"]) == 0
    held_out = "measurements.held_out=[log_3]"
    wide = "next_experiment.safety.margin=2"
    before = closed("measurements.fit=[log_1,log_2]", held_out, wide, "hydra.run.dir=first")
    assert before["verdict"] == "equivalent"
    assert before["next_experiment"]["sigma"] > before["next_experiment"]["needed"]

    assert main(["record", "source=next_experiment", "run=first", *MACHINE, *WEAK[:1], "output=logs"]) == 0
    after = closed("measurements.fit=[log_1,log_2,next_1]", held_out, "hydra.run.dir=second")
    assert (after["verdict"], after["ladder"][-1]["effects"]) == ("named", ["constant_offset@pendulum"])
