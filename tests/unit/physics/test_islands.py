import mujoco
import numpy as np

from dr_lab.physics.islands import skip_single_island

ROD = "<body><inertial mass='1' pos='0 0 -0.3' diaginertia='0.01 0.01 0.01'/><joint {joint}/>{child}</body>"
FRICTION = "axis='0 1 0' frictionloss='0.1'"
TREE = ROD.format(joint=FRICTION, child=ROD.format(joint=FRICTION, child=""))
ISLAND = int(mujoco.mjtDisableBit.mjDSBL_ISLAND)


def compiled(bodies: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{bodies}</worldbody></mujoco>")


def test_several_trees_keep_their_islands() -> None:
    assert not skip_single_island(compiled(TREE + TREE)).opt.disableflags & ISLAND


def test_one_tree_moves_the_same() -> None:
    plain, lean = compiled(TREE), skip_single_island(compiled(TREE))
    assert lean.opt.disableflags & ISLAND
    paths = []
    for model in (plain, lean):
        data = mujoco.MjData(model)
        data.qpos[:] = 1.0, -0.5
        for _ in range(1000):
            mujoco.mj_step(model, data)
        paths.append(data.qpos.copy())
    assert np.abs(paths[0]).max() > 0.01
    np.testing.assert_array_equal(paths[0], paths[1])
