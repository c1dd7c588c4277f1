"""The line of the MJCF that a finer time step asks to change."""

from pathlib import Path

import mujoco
import pytest

from dr_lab.physics.model import from_spec
from dr_lab.proposal.option_line import in_mjcf
from dr_lab.proposal.propose import Proposal
from dr_lab.proposal.robot import Robot

REST = '<worldbody><body name="b"><joint name="j"/><geom name="g" size="0.1"/></body></worldbody></mujoco>\n'


@pytest.mark.parametrize(
    ("head", "told"),
    [
        (
            '<mujoco>\n<!-- <option timestep="1"/> -->\n<option timestep="0.002" gravity="0 0 0"/>\n',
            'In model/it.xml, line 3, write <option gravity="0 0 0" timestep="0.001" integrator="RK4"/>.',
        ),
        (
            '<mujoco>\n<option\n  integrator="Euler"><flag energy="enable"/></option>\n',
            'In model/it.xml, line 2, write <option timestep="0.001" integrator="RK4">.',
        ),
        ("\n<mujoco>\n", 'In model/it.xml, add <option timestep="0.001" integrator="RK4"/> below line 2.'),
    ],
)
def test_the_line_what_to_write_and_what_happens_without_are_told(tmp_path: Path, head: str, told: str) -> None:
    path = tmp_path / "it.xml"
    path.write_text(head + REST)
    spec = mujoco.MjSpec.from_file(str(path))
    robot = Robot("it", path, spec, urdf=False, notes=())
    given = Proposal(robot, None, spec, False, (), (), {}, (), ())  # pyright: ignore[reportArgumentType]
    finer = spec.copy()
    finer.option.timestep, finer.option.integrator = 0.001, mujoco.mjtIntegrator.mjINT_RK4
    assert (
        in_mjcf(given, from_spec("it", finer, {}))
        == f"{told} Where you leave it, close does so by itself, as the other verbs do, and says so."
    )
