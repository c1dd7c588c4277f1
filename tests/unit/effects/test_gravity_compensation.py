"""A controller that carries the weight of its robot."""

import mujoco
import numpy as np
import pytest
from effect_machines import catalogue_effect, placed

from dr_lab.physics.model import Model, from_spec
from dr_lab.physics.simulator import Simulator

GRAVITY = "gravity_compensation@world.share"
ARM = """<mujoco><option timestep="0.002" integrator="RK4"/><worldbody><body pos="0 0 1">
  <joint name="shoulder" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="1" contype="0"/>
  <body pos="0.3 0 0"><joint name="elbow" axis="0 1 0"/>
    <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.02" mass="0.5" contype="0"/></body></body></worldbody>
<actuator><motor name="one" joint="shoulder"/>{elbow}</actuator></mujoco>"""
BOTH = ARM.format(elbow='<motor name="two" joint="elbow"/>')

FLYING = BOTH.replace("<worldbody>", '<worldbody><body><freejoint/><geom size="0.1" contype="0"/>').replace(
    "</worldbody>", "</body></worldbody>"
)
GANTRY = BOTH.replace('<joint name="shoulder"', '<joint name="shoulder" type="slide"').replace(
    '<joint name="elbow" axis="0 1 0"', '<joint name="elbow" type="slide" axis="0 0 1"'
)


def arm(text: str = BOTH, gravity: float = -9.81) -> Model:
    spec = mujoco.MjSpec.from_string(text)
    spec.option.gravity = [0.0, 0.0, gravity]
    return from_spec("arm", spec, {})


def fall(model: Model, values: dict[str, float]) -> np.ndarray:
    """Joint positions of an arm that is let go."""
    z, rest, controls = model.space.vector(values)[None], np.zeros((1, 1, 2)), np.zeros((1, 200, 2))
    return Simulator(model, 1, threads=1).replay(z, rest, rest, controls, controls[:, :1]).qpos[0]


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0, 1.2])
def test_what_is_carried_does_not_fall(share: float) -> None:
    """As if gravity were smaller by the share."""
    model = arm()
    found = fall(model.with_effect(placed(model, "gravity_compensation", "world")), {GRAVITY: share})
    np.testing.assert_allclose(found, fall(arm(gravity=-9.81 * (1 - share)), {}), atol=1e-9)


def test_it_acts_beside_laws_and_contexts_of_one_batch() -> None:
    """Laws ask for fields that are copied from compiled models; each simulation is carried by its own share."""
    model = arm()
    for name, site in (("gravity_compensation", "world"), ("load_dependent_friction", "elbow")):
        model = model.with_effect(placed(model, name, site))
    z = np.stack([model.space.vector({GRAVITY: share}) for share in (0.0, 0.5, 1.0)])
    rest, controls = np.zeros((3, 1, 2)), np.zeros((1, 100, 2))
    found = Simulator(model, 3, threads=1).replay(z, rest, rest, controls, controls[:, :1]).qpos
    for row, share in zip(found, (0.0, 0.5, 1.0), strict=True):
        np.testing.assert_allclose(row, fall(arm(gravity=-9.81 * (1 - share)), {})[:101], atol=1e-6)


def test_a_load_that_the_controller_does_not_know_is_not_carried() -> None:
    model = arm()
    for name, site in (("gravity_compensation", "world"), ("payload", "body_2")):
        model = model.with_effect(placed(model, name, site))
    compiled = model.compile(model.space.vector({GRAVITY: 1.0, "payload@body_2.mass": 0.3}))
    carried = dict(zip([compiled.body(k).name for k in range(compiled.nbody)], compiled.body_gravcomp, strict=True))
    assert carried.pop("payload@body_2") == 0.0
    assert [*carried.values()] == pytest.approx([0.0, 1.0, 1.0])


def test_what_the_file_carries_stays() -> None:
    text = BOTH.replace('<body pos="0.3 0 0">', '<body pos="0.3 0 0" gravcomp="1">')
    compiled = placed(arm(text), "gravity_compensation", "world")
    model = arm(text).with_effect(compiled)
    assert model.compile(model.space.vector({GRAVITY: 0.25})).body_gravcomp[1:].tolist() == pytest.approx([0.25, 1.25])


@pytest.mark.parametrize(
    ("model", "sites"),
    [
        pytest.param(arm(), ("world",), id="an arm"),
        pytest.param(arm(gravity=0.0), (), id="nothing weighs"),
        pytest.param(arm(ARM.format(elbow="")), (), id="a joint that swings freely"),
        pytest.param(arm(BOTH.replace('axis="0 1 0"', 'axis="0 0 1"')), (), id="joints that turn about the vertical"),
        pytest.param(arm(BOTH.replace('pos="0 0 1"', 'pos="0 0 1" euler="90 0 0"')), (), id="a base that is turned"),
        pytest.param(arm(FLYING), (), id="a free base"),
        pytest.param(arm(GANTRY), (), id="a weight that is the same in every pose"),
    ],
)
def test_it_sits_where_a_controller_can_carry_all(model: Model, sites: tuple[str, ...]) -> None:
    assert catalogue_effect("gravity_compensation").sites(model.nominal()) == sites
