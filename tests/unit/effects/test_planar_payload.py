import mujoco
import numpy as np
import pytest
from effect_machines import CONF, catalogue_effect, hanging, placed, with_effect

from dr_lab.effects.planar_payload import PlanarPayload
from dr_lab.physics.model import Model, from_spec, load
from dr_lab.physics.pseudo_inertia import Rooted, principal
from dr_lab.trajectory import Array

VALUES = {"mass": 0.3, "distance": 0.2, "side": -0.05, "spread": 0.04}
# The frame, the joint and the centre of the second link lie aside.
ARM = """<mujoco><compiler angle="radian"/><option gravity="0 0 -9.81"/><worldbody><body name="upper">
  <joint name="shoulder" axis="0 1 0"/><inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
  <body name="lower" pos="0.3 0 0" euler="0 0.6 0"><joint name="elbow" axis="0 1 0" pos="0.02 0.1 0"/>
  <inertial pos="0.12 0.05 0.03" mass="0.5" diaginertia="0.004 0.004 0.004"/></body></body></worldbody></mujoco>"""


def arm() -> Model:
    return from_spec("arm", mujoco.MjSpec.from_string(ARM), {})


def moving(model: mujoco.MjModel) -> Array:
    """Accelerations in some states."""
    data, rng, found = mujoco.MjData(model), np.random.default_rng(1), list[Array]()
    for _ in range(5):
        data.qpos[:], data.qvel[:] = rng.standard_normal((2, model.nq))
        mujoco.mj_forward(model, data)
        found.append(data.qacc.copy())
    return np.stack(found)


@pytest.mark.parametrize(
    ("name", "sites"),
    [
        ("furuta.xml", ("pole",)),  # the arm turns in a plane of its own, where gravity does not act
        ("double_pendulum_a0.xml", ("link2",)),
        ("strangers/seven.xml", ("link3",)),  # from the fourth on its joints feel all ten
        ("pendulum.xml", ()),  # one joint feels three
        ("cube.xml", ()),  # without a hinge
    ],
)
def test_it_sits_where_four_of_ten_are_felt(name: str, sites: tuple[str, ...]) -> None:
    assert catalogue_effect("planar_payload").sites(load("machine", CONF / "model" / name, {}).nominal()) == sites


def test_a_link_that_hangs_from_the_world_alone_is_no_site() -> None:
    assert catalogue_effect("planar_payload").sites(hanging().nominal()) == ()


def test_a_planar_arm_moves_as_with_any_body_of_the_same_mass_centre_and_inertia() -> None:
    """Also with one that is no rod, and lies aside of the plane."""
    ours = moving(with_effect(arm(), "planar_payload", "lower", **VALUES))
    spec = mujoco.MjSpec.from_string(ARM)
    first = np.array([0.1, 0.0, 0.03]) / np.hypot(0.1, 0.03)
    place = np.array([0.02, 0.1, 0.0]) + 0.2 * first - 0.05 * np.cross([0, 1, 0], first) + [0, 0.07, 0]
    second = 0.3 * np.diag([0.04**2 / 4, 0.05**2, 0.04**2 * 3 / 4])
    inertia, turn = principal(second)
    load = spec.body("lower").add_body(pos=place, mass=0.3, explicitinertial=True)
    load.ipos, load.inertia, load.iquat = np.zeros(3), inertia, turn
    theirs = moving(spec.compile())
    np.testing.assert_allclose(ours, theirs, rtol=1e-9)
    assert np.abs(ours - moving(arm().nominal())).max() > 0.1


def test_without_its_further_parameters_it_acts_as_a_payload() -> None:
    case = PlanarPayload.holds["payload"]
    further = dict.fromkeys(case.further, 0.0)
    ours = with_effect(arm(), "planar_payload", "lower", mass=0.4, distance=0.07, **further)
    theirs = with_effect(arm(), "payload", "lower", mass=0.4, distance=0.07)
    np.testing.assert_allclose(moving(ours), moving(theirs), rtol=1e-9)


def test_values_are_those_of_the_body_and_inertia_in_the_plane_is_kept() -> None:
    effect = catalogue_effect("planar_payload")
    assert isinstance(effect, PlanarPayload)
    values = {name: np.array([value, 2 * value]) for name, value in VALUES.items()}
    found = effect.values_of(effect.added(values))
    assert found.keys() == values.keys()
    for name, value in values.items():
        np.testing.assert_allclose(found[name], value)
    root = np.array([[[0.03, 0.01, 0.02], [0.0, 0.02, 0.005], [0.0, 0.0, 0.04]]])
    wide = Rooted(np.ones(1), np.zeros((1, 3)), root)
    np.testing.assert_allclose(effect.values_of(wide)["spread"] ** 2, np.trace(wide.second[0, :2, :2]))


def test_bounds_are_as_wide_as_the_machine_is_heavy() -> None:
    one = placed(arm(), "planar_payload", "lower")
    mass, distance, side, spread = one.parameters
    assert mass.high == pytest.approx(1.5)
    length = np.hypot(0.1, 0.03)
    assert (distance.nominal, distance.high, side.high, spread.high) == pytest.approx(
        (length, 5 * length, 5 * length, 3 * length)
    )
    assert all(0 < start["planar_payload@lower.mass"] < 0.2 for start in one.starts)
