import mujoco
import numpy as np
import pytest
from effect_machines import CONF, catalogue_effect, motion, placed, with_effect

from dr_lab.physics.model import Model, from_spec, load
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array


def sliding(floor: float = 1.0, box: float = 0.4, condim: int = 3) -> Model:
    """A box that slides over a floor; MuJoCo takes the larger coefficient of the two."""
    xml = f"""<mujoco><option timestep="0.001" cone="elliptic"/><worldbody>
      <geom type="plane" size="9 9 0.1" friction="{floor}" condim="1"/>
      <body name="box" pos="0 0 0.05"><joint name="slide" type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
        <geom type="box" size="0.1 0.1 0.05" mass="1" friction="{box}" condim="{condim}"/></body>
      <body name="ball" pos="0 3 0.1"><freejoint/><geom size="0.1" friction="0.7" condim="3"/></body>
    </worldbody></mujoco>"""
    return from_spec("sliding", mujoco.MjSpec.from_string(xml), {})


@pytest.mark.parametrize(("floor", "box", "factor"), [(1.0, 0.4, 0.3), (0.2, 0.5, 1.5), (1.0, 0.4, 1.0)])
def test_box_is_slowed_by_the_coefficient_times_gravity(floor: float, box: float, factor: float) -> None:
    model = with_effect(sliding(floor, box), "contact_friction", "box", factor=factor)
    time, _, speed = motion(model, 0.3, qvel=3.0).T
    settled = time > 0.1  # the box first sinks into the floor
    deceleration = -np.polyfit(time[settled], speed[settled], 1)[0]
    assert deceleration == pytest.approx(factor * max(floor, box) * 9.81, rel=5e-3)


def test_other_bodies_keep_their_contacts() -> None:
    plain = sliding().nominal()
    model = with_effect(sliding(), "contact_friction", "box", factor=0.3)
    found = []
    for compiled in (plain, model):
        data = mujoco.MjData(compiled)
        mujoco.mj_forward(compiled, data)
        ball = compiled.body("ball").id
        found += [c.friction.copy() for c in data.contact if ball in compiled.geom_bodyid[c.geom]]
    assert len(found) == 2
    np.testing.assert_array_equal(found[0], found[1])


def test_torsional_and_rolling_friction_stay() -> None:
    model = with_effect(sliding(), "contact_friction", "box", factor=0.5)
    sliding_friction = np.array([1.0, 0.7])  # with the floor and with the ball
    np.testing.assert_allclose(model.pair_friction[:, :2], 0.5 * np.stack([sliding_friction] * 2, axis=1))
    np.testing.assert_array_equal(model.pair_friction[:, 2:], [[0.005, 1e-4, 1e-4]] * 2)


def test_contacts_that_do_not_resist_sliding_are_left_out() -> None:
    effect = catalogue_effect("contact_friction")
    assert effect.sites(sliding().nominal()) == ("box", "ball")
    smooth = sliding(condim=1).spec.copy()
    smooth.geoms[-1].condim = 1
    assert effect.sites(smooth.compile()) == ()
    assert effect.sites(load("hopper", CONF / "model" / "hopper.xml", {}).nominal()) == ("foot",)


@pytest.mark.parametrize(
    ("name", "values"),
    [("contact_friction", {"factor": 0.5}), ("contact_stiffness", {"time_constant": 3.0, "damping_ratio": 1.0})],
)
def test_present_and_absent_stand_in_one_batch_beside_a_law(name: str, values: dict[str, float]) -> None:
    """A law writes contexts field by field, so that an effect must not change how many fields there are."""
    plain = sliding()
    model = plain.with_effect(placed(plain, name, "box"))
    model = model.with_effect(placed(model, "lugre_friction", "slide"))
    nominal = model.space.nominal
    other = model.space.vector({**model.space.mapping(nominal), **{f"{name}@box.{k}": v for k, v in values.items()}})
    together = moved(model, np.stack([nominal, other]))
    for row, z in zip(together, (nominal, other), strict=True):
        np.testing.assert_array_equal(row, moved(model, z[None])[0])
    assert abs(together[0] - together[1]).max() > 1e-6


def moved(model: Model, z: Array) -> Array:
    """Positions over 50 steps of the box that begins at 3 m/s, shape (contexts, 51, nq)."""
    simulator, compiled = Simulator(model, len(z), 1), model.nominal()
    qpos = np.broadcast_to(compiled.qpos0, (len(z), 1, compiled.nq))
    qvel = np.zeros((len(z), 1, compiled.nv))
    qvel[..., 0] = 3.0
    return simulator.replay(z, qpos, qvel, np.zeros((1, 50, compiled.nu)), np.zeros((1, 0, compiled.nu))).qpos
