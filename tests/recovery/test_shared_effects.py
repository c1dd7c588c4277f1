"""What all drives of a machine share is named as one effect, by logs of a machine that SciPy moves."""

import json
from pathlib import Path

import pytest

from dr_lab.__main__ import main

HIDDEN = {"actuator_lag": ("constant", 0.008), "actuator_delay": ("delay", 0.006), "voltage_sag": ("slope", 0.15)}
NAMES = {"actuator_lag": "tau", "actuator_delay": "delay", "voltage_sag": "slope"}


@pytest.mark.slow
@pytest.mark.parametrize("effect", HIDDEN)
def test_both_drives_of_a_double_pendulum(effect: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    key, value = HIDDEN[effect]
    hide = ["plant/hidden=general/several"]
    for part, site in (("one", "shoulder"), ("two", "elbow")):
        place = f"plant.hidden.effects.{part}"
        hide += [f"+plant/hidden@{place}=general/{effect}", f"{place}.site={site}", f"{place}.{key}={value}"]
    assert main(["record", "plant=double_pendulum", *hide, "hydra.run.dir=logs"]) == 0
    logs = ["model=double_pendulum", "measurements=double_pendulum", "measurements.logs=[logs/*.mcap]"]
    assert main(["close", *logs, "threads=1", "hydra.run.dir=run"]) == 0
    report = json.loads(Path("run/report.json").read_text(encoding="utf-8"))
    assert report["verdict"] == "named"
    last = report["ladder"][-1]
    assert last["effects"] == [f"{effect}@all_actuators"]
    assert last["parameters"][f"{effect}@all_actuators.{NAMES[effect]}"]["value"] == pytest.approx(value, rel=0.02)
