"""What `close` answers on real logs whose missing effect is known; needs DR_LAB_DATA, the folder that holds them."""

import json
import os
from pathlib import Path

import pytest

from dr_lab.__main__ import main

pytestmark = pytest.mark.skipif(
    "DR_LAB_DATA" not in os.environ, reason="DR_LAB_DATA is not set: export DR_LAB_DATA=FOLDER of the real data sets"
)


def answered(folder: Path, *words: str) -> list[str]:
    """Effects that a run of ``dr-lab close`` added, in order."""
    assert main(["close", *words, "threads=1", f"hydra.run.dir={folder}"]) == 0
    last = json.loads((folder / "report.json").read_text())["ladder"][-1]
    return list(last["effects"])


@pytest.mark.parametrize(
    ("ball", "effects"),
    [
        pytest.param("bowling_ball", [], marks=pytest.mark.slow),
        pytest.param("golf_ball", [], marks=pytest.mark.slow),
        pytest.param("orange_whiffle_ball", ["viscous_friction@ball"], marks=pytest.mark.slow),
    ],
)
def test_light_balls_feel_the_air_and_heavy_ones_do_not(ball: str, effects: list[str], tmp_path: Path) -> None:
    assert answered(tmp_path / "run", "experiment=ball_drops", f"ball={ball}") == effects


@pytest.mark.slow
@pytest.mark.parametrize(
    ("experiment", "first"),
    [
        ("dfki_payload", "payload@link"),
        ("dfki_simple_pendulum", "coulomb_friction@pendulum"),
        ("multiarm_single", "viscous_friction@arm1"),
        ("servo_xl330", "load_dependent_friction@link"),
    ],
)
def test_the_known_effect_comes_first(experiment: str, first: str, tmp_path: Path) -> None:
    assert answered(tmp_path / "run", f"experiment={experiment}")[0] == first
