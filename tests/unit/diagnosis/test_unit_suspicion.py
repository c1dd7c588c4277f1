from dataclasses import dataclass, field
from typing import cast

import mujoco
import numpy as np
import pytest
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.diagnosis.evidence.score import ChannelScore, Score
from dr_lab.diagnosis.faults.unit_suspicion import (
    FewWindows,
    Misreading,
    ReadingSettings,
    suspect_degrees,
    suspect_misread,
)
from dr_lab.physics.model import Model, from_spec
from dr_lab.trajectory import Log, MeasurementSet, Noise, Signal

SENSORS = """<mujoco><worldbody><body><joint name="j"/><geom size="0.1" mass="1"/></body></worldbody><sensor>
  <jointactuatorfrc name="a" joint="j"/><jointactuatorfrc name="b" joint="j"/><jointactuatorfrc name="c" joint="j"/>
</sensor></mujoco>"""
LOGS = ["measurements.fit=['log_1[0:3]']", "measurements.held_out=['log_5[0:3]']"]


def suspicion(*overrides: str) -> Misreading | None:
    cfg = compose("compare", [*LOGS, *overrides])
    built = {
        key: instantiate(cfg[key], _convert_="all") for key in ("model", "measurements", "faults", "windows", "solver")
    }
    rules = built["faults"].reading
    few = FewWindows(built["model"], rules, built["windows"], built["solver"], threads=1)
    return suspect_degrees(few, built["measurements"])


def test_smooth_degrees_without_steps_are_told_by_the_model() -> None:
    scales = [f"measurements.outputs.{joint}.position.scale=57.29577951308232" for joint in ("arm", "pole")]
    limits = ["measurements.contract.unit_quantum=0", "measurements.contract.speed_limit=1.0e9"]
    found = suspicion(*scales, *limits)
    assert found is not None
    assert found.channels == ("arm.position", "pole.position")
    assert found.chi2 > 100 * found.chi2_read_anew


def test_radians_are_not_suspected_whatever_the_model_lacks() -> None:
    assert suspicion() is None
    assert suspicion("measurements.outputs.arm.position.sign=-1") is None


@dataclass
class Followed:
    """Logs of which a model follows a sensor once it is turned; each is asked for its score once a reading."""

    rules: ReadingSettings
    asked: int = 0
    model: Model = field(default_factory=lambda: from_spec("it", mujoco.MjSpec.from_string(SENSORS), {}))

    def score(self, measured: MeasurementSet) -> Score:
        self.asked += 1
        right = measured.held_out[0].outputs["sensor.c"].value[0] < 0
        squares = {"sensor.a": 20.0, "sensor.b": 10.0, "sensor.c": 1.0 if right else 1e5}
        one = np.ones(1)
        channels = {name: ChannelScore(each * one, one, 1.0, instrumental=False) for name, each in squares.items()}
        return Score(sum(squares.values()), {}, {}, {}, one, one, np.zeros(1, np.intp), 0, channels)


@pytest.mark.parametrize("most", [1, 3])
def test_of_many_sensors_those_are_read_otherwise_that_are_followed_worst(most: int) -> None:
    signals = {n: Signal(n, "1", np.arange(3.0), np.ones(3)) for n in ("sensor.a", "sensor.b", "sensor.c")}
    noise = {name: Noise(1.0, "1", "given") for name in signals}
    few = Followed(ReadingSettings(windows=3, follows=100.0, better=30.0, most=most))
    found = suspect_misread(cast(FewWindows, few), MeasurementSet("it", (), (Log("a", signals, {}),), noise, {}))
    assert found is not None
    assert (found.channels, found.turned) == (("sensor.c",), True)
    assert few.asked == 1 + most
