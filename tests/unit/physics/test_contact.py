import mujoco
import numpy as np
import pytest

from dr_lab.physics.contact import nothing_touches, skip_idle_collisions

XML = """
<mujoco>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 0.1" contype="{floor}" conaffinity="0"/>
    <body name="ball" pos="0 0 0.5">
      <freejoint/><geom name="ball" size="0.1" contype="0" conaffinity="{ball}"/>
    </body>
  </worldbody>
  {extra}
</mujoco>
"""
PAIR = '<contact><pair geom1="floor" geom2="ball"/></contact>'


def compiled(floor: int, ball: int, extra: str = "") -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(XML.format(floor=floor, ball=ball, extra=extra))


@pytest.mark.parametrize(
    ("floor", "ball", "extra", "expected"), [(1, 1, "", False), (1, 2, "", True), (0, 0, "", True), (0, 0, PAIR, False)]
)
def test_bits_and_pairs_decide_what_may_touch(floor: int, ball: int, extra: str, expected: bool) -> None:
    assert nothing_touches(compiled(floor, ball, extra)) is expected


def test_a_geom_does_not_touch_itself() -> None:
    alone = "<mujoco><worldbody><body><freejoint/><geom size='0.1'/></body></worldbody></mujoco>"
    assert nothing_touches(mujoco.MjModel.from_xml_string(alone))


@pytest.mark.parametrize(("ball", "height"), [(1, 0.1), (2, None)])
def test_what_may_touch_still_lands_and_the_rest_moves_the_same(ball: int, height: float | None) -> None:
    plain, lean = compiled(1, ball), skip_idle_collisions(compiled(1, ball))
    paths = []
    for model in (plain, lean):
        data = mujoco.MjData(model)
        for _ in range(1000):
            mujoco.mj_step(model, data)
        paths.append(data.qpos.copy())
    np.testing.assert_array_equal(paths[0], paths[1])
    if height is not None:
        assert paths[1][2] == pytest.approx(height, abs=5e-3)
