"""What a slider-crank lacks is found although its pin is not measured, by logs of its own equation of motion."""

import json
from pathlib import Path

import pytest
import yaml
from slider_crank import MJCF, SLIDER_MASS, logs, written

from dr_lab.__main__ import main

FRICTION = 2.0  # N


@pytest.mark.slow
def test_init_finds_the_zero_that_closes_the_chain(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("crank.xml").write_text(MJCF.format(""), encoding="utf-8")
    assert main(["init", "crank.xml", *written(tmp_path, logs("ab", 3.0), 0.4)]) == 0
    page = yaml.safe_load(Path("mine/measurements/slider_crank.yaml").read_text(encoding="utf-8"))
    assert page["outputs"]["slider.position"]["offset"] == pytest.approx(-0.4, abs=1e-4)


@pytest.mark.slow
def test_friction_of_the_slider_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("crank.xml").write_text(MJCF.format(""), encoding="utf-8")
    assert main(["init", "crank.xml", *written(tmp_path, logs("abcd", friction=FRICTION), 0.4)]) == 0
    close = [
        "close",
        "--config-dir",
        "mine",
        "model=slider_crank",
        "measurements=slider_crank",
        "threads=1",
        "hydra.run.dir=run",
    ]
    effects = "effect=[coulomb_friction,viscous_friction,constant_offset]"
    assert main([*close, effects, "windows.seconds=6"]) == 0
    report = json.loads(Path("run/report.json").read_text(encoding="utf-8"))
    last = report["ladder"][-1]
    assert (report["verdict"], last["effects"]) == ("named", ["coulomb_friction@slider"])
    found = {name: entry["value"] for name, entry in last["parameters"].items()}
    assert found["coulomb_friction@slider.torque"] == pytest.approx(FRICTION, rel=0.05)
    assert found["slider.mass"] == pytest.approx(SLIDER_MASS, rel=0.02)
