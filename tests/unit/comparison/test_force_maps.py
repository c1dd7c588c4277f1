"""The picture of a learned force is the force, near the states of the log and nowhere else."""

import mujoco
import numpy as np
import pytest

from dr_lab.comparison.force_maps import force_maps
from dr_lab.effects.learned_force import LearnedForce
from dr_lab.physics.radial_basis import Input, RadialBasis, Seen

MODEL = mujoco.MjModel.from_xml_string(
    """<mujoco><worldbody><body><joint name="rail" type="slide"/><geom size=".1"/>
    <body><joint name="hinge"/><geom size=".1" pos=".1 0 0"/></body></body></worldbody></mujoco>"""
)


def test_a_bell_is_where_it_is_and_blank_where_nothing_was_seen() -> None:
    inputs = (Input("place", "rail", 0.5), Input("velocity", "rail", 2.0), Input("velocity", "hinge", 1.0))
    basis = RadialBasis(inputs, np.array([[0.0, 0.0, 3.0]]), near=1.0, far=2.0)
    force = LearnedForce(basis, np.array([4.0]), "N")
    # two states: at the bell's centre with the hinge at 3 rad/s, and far from it
    seen = Seen(np.array([[0.0, 0.0], [4.0, 0.0]]), np.array([[0.0, 3.0], [8.0, 3.0]]), np.zeros((2, 0)))
    shown = force_maps(MODEL, {"rail": (force, 0.5)}, seen)["rail"]
    q, v = np.meshgrid(shown.position.values, shown.velocity.values, indexing="ij")
    away = np.sqrt((q / 0.5) ** 2 + (v / 2.0) ** 2)
    near = away < 1.0
    np.testing.assert_allclose(shown.force[near], 2.0 * np.exp(-(away[near] ** 2) / 2))
    assert np.isnan(shown.force[away > 2.0]).all()
    assert near.any()
    assert (shown.position.unit, shown.velocity.unit, shown.unit) == ("m", "m/s", "N")
    np.testing.assert_array_equal(shown.place, [[0.0, 0.0], [4.0, 8.0]])
    assert shown.reach() == pytest.approx(float(np.nanmax(shown.force)))


def test_an_odd_force_is_known_on_both_sides() -> None:
    basis = RadialBasis((Input("velocity", "hinge", 1.0),), np.array([[2.0]]), near=0.5, far=1.0, odd=True)
    np.testing.assert_allclose(basis.known(np.array([[2.0], [-2.0], [0.0], [2.75]])), [1.0, 1.0, 0.0, 0.5])
