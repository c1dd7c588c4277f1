import mujoco
import numpy as np
import pytest
from effect_machines import motion, placed, with_effect

from dr_lab.physics.model import Model, from_spec

IMPEDANCE, GRAVITY = 0.9, 9.81


def dropped(solref: str, height: float = 0.1) -> Model:
    """A ball on a vertical rail above the floor, with contacts of constant impedance."""
    xml = f"""<mujoco><option timestep="0.001"/>
      <default><geom condim="1" solref="{solref}" solimp="{IMPEDANCE} {IMPEDANCE} 0.01"/></default><worldbody>
      <geom type="plane" size="1 1 0.1"/>
      <body name="ball" pos="0 0 {height}"><joint type="slide" axis="0 0 1"/><geom size="0.1" mass="1"/></body>
    </worldbody></mujoco>"""
    return from_spec("dropped", mujoco.MjSpec.from_string(xml), {})


@pytest.mark.parametrize(("slower", "deader"), [(1.0, 1.0), (2.0, 1.0), (0.5, 1.0), (1.0, 1.5), (1.5, 0.8)])
def test_ball_sinks_in_as_far_as_the_constraint_gives(slower: float, deader: float) -> None:
    model = with_effect(dropped("0.02 1"), "contact_stiffness", "ball", time_constant=slower, damping_ratio=deader)
    depth = -motion(model, 3.0)[-1, 1]
    assert depth == pytest.approx(GRAVITY * (1 - IMPEDANCE) * (0.02 * slower * deader) ** 2, rel=1e-3)


@pytest.mark.parametrize(("slower", "deader"), [(2.0, 1.0), (1.0, 0.3), (0.7, 1.8)])
def test_direct_numbers_stand_for_the_same_contact(slower: float, deader: float) -> None:
    """T = 2/damping and zeta = damping/(2 √stiffness): the same ball for both forms, before and after."""
    values = {"time_constant": slower, "damping_ratio": deader}
    paths = [
        motion(with_effect(dropped(solref, 0.12), "contact_stiffness", "ball", **values), 0.3)
        for solref in ("0.02 0.8", "-3906.25 -100")
    ]
    np.testing.assert_allclose(paths[0], paths[1], atol=1e-9)


def test_a_livelier_contact_throws_back() -> None:
    def rebound(deader: float) -> float:
        values = {"time_constant": 1.0, "damping_ratio": deader}
        model = with_effect(dropped("0.02 1", 0.3), "contact_stiffness", "ball", **values)
        return float(motion(model, 0.5)[:, 2].max())

    heights = [rebound(share) for share in (1.0, 0.5, 0.25)]
    assert heights[0] < heights[1] < heights[2]
    assert heights[2] > 3 * heights[0]


def test_time_constants_stay_above_two_time_steps() -> None:
    slower, deader = placed(dropped("0.003 1"), "contact_stiffness", "ball").parameters
    assert slower.low == pytest.approx(2 / 3)
    assert (slower.nominal, slower.high, deader.nominal) == (1.0, 4.0, 1.0)
    assert placed(dropped("0.001 1"), "contact_stiffness", "ball").parameters[0].low == 1.0
    assert placed(dropped("-100 -10"), "contact_stiffness", "ball").parameters[0].low == 0.25
