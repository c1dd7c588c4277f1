"""Commands that no motion shows, in the only columns that are left."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from own_robot import write_csv
from played_logs import played

from dr_lab.__main__ import main

ROBOT = """<mujoco model="it"><option timestep="0.001" integrator="RK4"/><worldbody><body name="disk">
  <joint name="shaft" axis="0 0 1" damping="{damping}"/><geom name="disk" type="cylinder" size="0.05 0.01" mass="0.5"/>
</body></worldbody><actuator><motor name="drive" joint="shaft" gear="0.01"/></actuator></mujoco>"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def proposed(moved: str, columns: tuple[str, ...]) -> dict[str, Any]:
    """What init makes of a disk under a known force, or a random walk, beside columns of numbers without sense."""
    Path("it.xml").write_text(ROBOT.format(damping=0.001))
    paths = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        time, place, _ = played(ROBOT.format(damping=0.001), [0.1], 4.0, seed=seed)
        if moved == "walk":
            place = np.repeat(rng.normal(size=(len(time) // 20 + 1, 1)).cumsum(0), 20, axis=0)[: len(time)]
        rest = {name: np.repeat(rng.normal(size=len(time) // 40 + 1), 40)[: len(time)] for name in columns}
        paths.append(str(write_csv(Path(f"logs/{seed}.csv"), {"t": time, "angle_rad": place[:, 0], **rest})))
    assert main(["init", "it.xml", *paths]) == 0
    return yaml.safe_load(Path("mine/measurements/it.yaml").read_text(encoding="utf-8"))


def test_the_only_column_left_is_the_only_command_left(capsys: pytest.CaptureFixture[str]) -> None:
    assert proposed("walk", ("c9",))["commands"] == {"drive": {"column": "c9", "unit": "1"}}
    told = capsys.readouterr().out
    assert "by elimination; 1 of ctrl is 0.01 N·m" in told
    assert "drive: c9 is read as its command as no other column is left" in told


def test_of_two_columns_neither_is_chosen() -> None:
    assert proposed("walk", ("c9", "k8"))["commands"] == {}
