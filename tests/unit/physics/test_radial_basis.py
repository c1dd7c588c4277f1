"""Bell curves: near any smooth function where something was seen, and exactly nothing elsewhere."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from dr_lab.errors import ModelError
from dr_lab.physics.radial_basis import Input, RadialBasis, Seen, around, features
from dr_lab.trajectory import Array

INPUTS = (Input("place", "rail", 0.5), Input("velocity", "rail", 2.0))
POINTS = np.random.default_rng(0).uniform(-2.0, 2.0, (1500, 2))
MODEL = mujoco.MjModel.from_xml_string(
    """<mujoco><worldbody><body><joint name="rail" type="slide"/><geom size=".1"/>
    <body><joint name="hinge"/><geom size=".1"/></body></body></worldbody>
    <actuator><motor name="drive" joint="rail"/></actuator></mujoco>"""
)


def wave(points: Array) -> Array:
    return np.sin(1.5 * points[:, 0]) * np.cos(points[:, 1])


def test_a_smooth_function_is_followed_between_the_points() -> None:
    basis = around(INPUTS, POINTS, 100, 1.0)
    weights = np.asarray(np.linalg.lstsq(basis.functions(POINTS), wave(POINTS))[0], np.float64)
    new = np.random.default_rng(1).uniform(-1.9, 1.9, (500, 2))
    np.testing.assert_allclose(basis.functions(new) @ weights, wave(new), atol=0.02)
    np.testing.assert_allclose(
        basis.bells(new) @ basis.coefficients(weights), basis.functions(new) @ weights, atol=1e-9
    )


def test_it_fades_to_exactly_nothing_beyond_what_was_seen() -> None:
    basis = around(INPUTS, POINTS, 100, 1.0)
    way = np.linspace(0.0, 6.0, 601)
    force = basis.bells(np.stack([way, np.zeros_like(way)], axis=1)).sum(1)
    assert (force[way > 2.0 + basis.far] == 0.0).all()
    assert np.abs(np.diff(force)).max() < 0.05 * force.max()  # no step on the way
    assert (basis.bells(POINTS).sum(1) > 0.5).all()


def test_functions_have_the_covariance_of_the_kernel() -> None:
    centres = np.array([[0.0, 0.0], [0.7, 0.0], [0.0, 1.2]])
    values = RadialBasis(INPUTS, centres, 0.5, 1.5).functions(centres)
    squared = ((centres[:, None] - centres) ** 2).sum(2)
    np.testing.assert_allclose(values @ values.T, np.exp(-0.5 * squared), atol=1e-6)


def test_an_odd_force_is_the_same_either_way() -> None:
    inputs = (Input("angle", "hinge", 0.5), Input("velocity", "hinge", 1.0))
    state = np.random.default_rng(2).normal(size=(200, 2))
    ahead, back = (Seen(s * np.pad(state[:, :1], ((0, 0), (1, 0))), s * np.pad(state[:, 1:], ((0, 0), (1, 0))), state)
                   for s in (1.0, -1.0))  # fmt: skip
    points = [features(inputs, MODEL, seen) for seen in (ahead, back)]
    basis = replace(around(inputs, points[0][:100], 30, 1.0), odd=True)
    weights = np.random.default_rng(3).normal(size=len(basis.centres))
    np.testing.assert_allclose(basis.functions(points[0]) @ weights, -basis.functions(points[1]) @ weights, atol=1e-9)


def test_a_turn_leads_back_to_the_same_point() -> None:
    seen = [Seen(np.array([[0.0, 0.3 + turn]]), np.zeros((1, 2)), np.zeros((1, 1))) for turn in (0.0, 2 * np.pi)]
    once, again = (features((Input("angle", "hinge", 0.2),), MODEL, each) for each in seen)
    np.testing.assert_allclose(once, again, atol=1e-12)


def test_a_model_without_the_joint_is_told() -> None:
    with pytest.raises(ModelError, match="the place of 'pole'"):
        features((Input("place", "pole", 1.0),), MODEL, Seen(np.zeros((1, 2)), np.zeros((1, 2)), np.zeros((1, 1))))
