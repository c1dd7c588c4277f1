"""A body whose place nothing measures begins a window on its feet."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from diagnosis_machines import windows_settings
from walker import walked, walker

from dr_lab.diagnosis.windows.free_start import free_bodies
from dr_lab.diagnosis.windows.standing import stand
from dr_lab.diagnosis.windows.start_prior import StartPrior
from dr_lab.trajectory import Array

SETTINGS = windows_settings()


def stood(model: mujoco.MjModel, qpos: Array, qvel: Array) -> StartPrior:
    """The prior of states of which the body's place and velocity are not known."""
    prior = StartPrior(qpos.copy(), qvel.copy(), np.zeros_like(qvel), np.ones(2 * model.nv))
    prior.qpos[:, :3], prior.qvel[:, :3] = [0.3, -0.2, 0.6], 0.0
    stand(prior, free_bodies(model, ("sensor.turn",))[0], model, SETTINGS)
    return prior


def test_height_and_velocity_are_those_of_a_machine_that_walks() -> None:
    model, qpos, qvel = walked()
    prior = stood(model, qpos, qvel)
    np.testing.assert_allclose(prior.qpos[:, 2], qpos[:, 2], atol=2e-3)
    np.testing.assert_array_equal(prior.qpos[:, :2], np.tile([0.3, -0.2], (len(qpos), 1)))
    assert np.abs(qvel[:, 0]).max() > 0.1  # there is something to tell
    assert np.median(np.abs(prior.qvel[:, :3] - qvel[:, :3])) < 0.02
    assert prior.std[2] == SETTINGS.footing
    assert (prior.std[model.nv : model.nv + 3] < 0.5).all()
    np.testing.assert_array_equal(prior.std[:2], 1.0)


def test_a_machine_at_rest_sinks_by_its_weight() -> None:
    """Contacts give: without that it would begin every window with a fall."""
    model = mujoco.MjModel.from_xml_string(walker())
    data = mujoco.MjData(model)
    for _ in range(4000):
        data.ctrl[:] = [0.5, -1.0, 0.5, -1.0]
        mujoco.mj_step(model, data)
    prior = stood(model, data.qpos[None].copy(), np.zeros((1, model.nv)))
    assert prior.qpos[0, 2] == pytest.approx(data.qpos[2], abs=2e-4)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (("0 0 -9.81", "0 0 0"), "nothing pulls it down"),
        (('contype="2" conaffinity="1"', 'contype="0" conaffinity="0"'), "nothing bears it"),
    ],
)
def test_what_nothing_holds_stays_where_it_is(change: tuple[str, str], why: str) -> None:
    xml = walker().replace('integrator="implicitfast"', 'integrator="implicitfast" gravity="0 0 -9.81"')
    model = mujoco.MjModel.from_xml_string(xml.replace(*change))
    prior = stood(model, np.tile(model.qpos0, (2, 1)), np.ones((2, model.nv)))
    np.testing.assert_array_equal(prior.qpos[:, 2], 0.6, why)
    np.testing.assert_array_equal(prior.std, 1.0, why)


def test_a_body_that_lies_on_its_own_shape_is_not_put_on_feet() -> None:
    box = """<mujoco><worldbody><geom type="plane" size="1 1 1"/><body name="trunk" pos="0 0 0.6"><freejoint/>
      <geom size="0.1"/></body></worldbody>
      <sensor><framequat name="turn" objtype="xbody" objname="trunk"/></sensor></mujoco>"""
    model = mujoco.MjModel.from_xml_string(box)
    assert stood(model, model.qpos0[None].copy(), np.zeros((1, 6))).qpos[0, 2] == 0.6


def test_many_joints_are_fitted_to_fewer_windows() -> None:
    many = replace(SETTINGS, unknowns=800, length=0.3, seconds=20.0)
    assert many.of_machine(2).most == 67
    assert many.of_machine(6).most == 66
    assert many.of_machine(18).most == 22
    assert many.of_machine(1000).most == 1
