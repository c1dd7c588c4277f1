"""Domains of the four-legged machine: what each of its parameters does to it."""

import mujoco
import numpy as np
import pytest
from settings import setting

NOMINAL = [-9.81, 0.0, 0.0, 0.0, 1.0, 5.0]
ORDER = ("gravity", "wind.x", "wind.y", "wind.z", "friction", "density")


def at(**values: float) -> mujoco.MjModel:
    model = setting("ant", "env/context=ant/domains").model
    return model.compile(model.space.vector({name.replace("_", "."): value for name, value in values.items()}))


def test_nominal_is_gymnasiums_machine_in_air() -> None:
    space = setting("ant", "env/context=ant/domains").model.space
    assert space.names == ORDER
    np.testing.assert_allclose(space.nominal, NOMINAL)
    ours, theirs = at(), setting("ant").model.nominal()
    for field in ("body_mass", "body_inertia", "geom_friction", "dof_damping"):
        np.testing.assert_allclose(getattr(ours, field), getattr(theirs, field), rtol=1e-12, err_msg=field)
    assert (ours.opt.density, theirs.opt.density) == (1.2, 0.0)


def test_density_scales_the_mass_and_friction_that_of_contacts() -> None:
    assert at(density=5.5).body_subtreemass[0] == pytest.approx(1.1 * at().body_subtreemass[0], rel=1e-12)
    rough = at(friction=1.06)
    data = mujoco.MjData(rough)
    data.qpos[2] = 0.2  # the torso, of radius 0.25 m, in the floor
    mujoco.mj_forward(rough, data)
    assert data.ncon > 0
    np.testing.assert_allclose(data.contact.friction[:, 0], 1.06)


def test_wind_pushes_along_its_way_and_gravity_by_the_weight() -> None:
    forces = []
    for wind in (-1.0, 1.0):
        model = at(wind_x=wind)
        data = mujoco.MjData(model)
        data.qpos[2] = 2.0  # in the air
        mujoco.mj_forward(model, data)
        forces.append(float(data.qfrc_fluid[0]))
    assert forces[0] == pytest.approx(-forces[1], rel=1e-9)
    assert 0.05 < forces[1] < 1.0  # N
    heavy = at(gravity=-10.3005)
    data = mujoco.MjData(heavy)
    data.qpos[2] = 2.0
    mujoco.mj_forward(heavy, data)
    assert data.qfrc_bias[2] == pytest.approx(10.3005 * heavy.body_subtreemass[0], rel=1e-9)  # N, at rest
