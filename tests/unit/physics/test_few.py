"""A few simulations are begun without threads, and come out as with them."""

import mujoco
import numpy as np
import pytest
from mujoco.batch import Batch

from dr_lab.physics.few import in_calls

ARM = """<mujoco><worldbody><body name="arm"><joint name="hinge" axis="0 1 0"/>
<geom name="rod" type="capsule" size=".02" fromto="0 0 0 .3 0 0"/></body></worldbody></mujoco>"""


def batch(threads: int) -> Batch:
    return Batch(mujoco.MjModel.from_xml_string(ARM), 40, threads)


@pytest.mark.parametrize(
    ("threads", "count", "calls"), [(1, 3, [3]), (2, 0, [0]), (2, 3, [1, 1, 1]), (2, 8, [1] * 8), (2, 9, [9])]
)
def test_few_simulations_go_one_by_one_where_there_are_threads(threads: int, count: int, calls: list[int]) -> None:
    ids = np.arange(0, 3 * count, 3)
    found = list(in_calls(batch(threads), ids))
    assert [len(each) for each in found] == calls
    np.testing.assert_array_equal(np.concatenate(found), ids)


@pytest.mark.parametrize("count", [3, 12])
def test_the_outcome_is_that_of_one_call(count: int) -> None:
    whole, parted, ids = batch(2), batch(2), np.arange(0, 3 * count, 3)
    for each in (whole, parted):
        each.expand("body_mass")[ids, 1] = np.linspace(0.5, 1.5, count)
        each.bind("qpos")[:, 0] = np.linspace(0.0, 1.0, 40)
        for some in [ids] if each is whole else in_calls(each, ids):
            each.set_const(some)
            each.forward(some)
    for name in ("qacc", "xpos", "qfrc_bias"):
        np.testing.assert_array_equal(whole.bind(name), parted.bind(name))
    np.testing.assert_array_equal(whole.expand("dof_invweight0"), parted.expand("dof_invweight0"))
