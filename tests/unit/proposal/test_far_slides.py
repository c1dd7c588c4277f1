"""Slides whose numbers are read as metres and cannot be."""

from pathlib import Path

import pytest
import yaml
from played_logs import played, write_log

from dr_lab.__main__ import main

# The size of the model is some tenths of a metre.
CART = """<mujoco model="it"><option timestep="0.001" integrator="RK4" gravity="0 0 0"/><worldbody><body name="cart">
  <joint name="rail" type="slide" axis="1 0 0" stiffness="300" damping="2"{}/>
  <geom type="box" size="0.1 0.05 0.05" mass="1"/></body></worldbody></mujoco>"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def told(capsys: pytest.CaptureFixture[str], header: str, factor: float, limits: str = "") -> str:
    """What init prints of a cart that swings by ±5 cm, in a unit of so many to the metre."""
    Path("it.xml").write_text(CART.format(limits))
    time, place, _ = played(CART.format(""), [0.05], 3.0)
    assert main(["init", "it.xml", write_log("a", header, time, factor * place)]) == 0
    return capsys.readouterr().out


def test_millimetres_that_are_read_as_metres_are_doubted(capsys: pytest.CaptureFixture[str]) -> None:
    """The motion is linear, so that it shows no unit: ±50 are ±50 m, at 300 · 50 m/s²."""
    page = told(capsys, "t,displacement", 1000.0)
    assert "rail moves over 9" in page
    assert "times the model's size of 0." in page
    assert "Are the numbers millimetres? Then write unit: mm, a factor of 0.001, by which it moves 0." in page


@pytest.mark.parametrize(("said", "unit", "factor"), [("um", "um", 1e6), ("[µm]", "um", 1e6), ("cm", "cm", 1e2)])
def test_a_unit_that_a_name_says_is_believed(
    said: str, unit: str, factor: float, capsys: pytest.CaptureFixture[str]
) -> None:
    """Linear scales count in micrometres."""
    told(capsys, f"t,scale {said}", factor)
    page = yaml.safe_load(Path("mine/measurements/it.yaml").read_text(encoding="utf-8"))
    assert page["outputs"] == {"rail.position": {"column": f"scale {said}", "unit": unit}}


@pytest.mark.parametrize(
    ("header", "factor", "limits"),
    [
        ("t,displacement", 1.0, ""),
        ("t,displacement_mm", 1000.0, ""),
        ("t,displacement", 1000.0, ' limited="true" range="-60 60"'),  # a model of 120 m
    ],
)
def test_what_a_machine_may_do_is_not_doubted(
    header: str, factor: float, limits: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "moves over" not in told(capsys, header, factor, limits)
