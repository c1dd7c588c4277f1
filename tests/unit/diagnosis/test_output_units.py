"""A hinge that is measured in metres, and a slide in radians, are refused."""

import mujoco
import numpy as np
import pytest

from dr_lab.diagnosis.checks.output_units import require_output_units
from dr_lab.errors import DataError
from dr_lab.trajectory import Log, Signal

MACHINE = mujoco.MjModel.from_xml_string("""<mujoco><worldbody>
  <body><joint name="drum" type="hinge"/><geom size="0.1"/>
    <body><joint name="rope" type="slide"/><geom size="0.1"/></body></body>
</worldbody></mujoco>""")


def log(channel: str, unit: str) -> Log:
    return Log("a", {channel: Signal(channel, unit, np.arange(3.0), np.zeros(3))}, {})


@pytest.mark.parametrize(
    ("channel", "unit", "told"),
    [
        ("drum.position", "m", "Channel drum.position is declared in m, but joint drum is a hinge: expected an angle"),
        ("drum.velocity", "m/s", "expected an angle, such as rad/s. Correct the unit of measurements.outputs.drum.vel"),
        ("rope.position", "rad", "joint rope is a slide: expected a length, such as m. .*as scale its way over each"),
    ],
)
def test_the_other_quantity_is_refused(channel: str, unit: str, told: str) -> None:
    with pytest.raises(DataError, match=told):
        require_output_units(MACHINE, [log("drum.position", "rad"), log(channel, unit)])


@pytest.mark.parametrize(
    ("channel", "unit"), [("drum.position", "rad"), ("rope.velocity", "m/s"), ("drum.position", "")]
)
def test_what_fits_or_is_not_said_passes(channel: str, unit: str) -> None:
    require_output_units(MACHINE, [log(channel, unit)])
