"""A learned force as an effect: a motion with a closed form, nothing beyond what was seen, the way through a run."""

from pathlib import Path

import numpy as np
import pytest
from effect_machines import block, scales_of
from test_force_laws import played

from dr_lab.comparison.export import inexpressible, write_context
from dr_lab.effects.effect import PlacedEffect, place
from dr_lab.effects.from_run import from_run
from dr_lab.effects.learned_force import FILE, LearnedForce, read_learned_forces, write_learned_forces
from dr_lab.effects.residual_force import ResidualForce, learned_forces, residual_force
from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.physics.context import ContextEstimate
from dr_lab.physics.radial_basis import Input, Seen, around, features

STIFFNESS, REACH = 18.0, 0.5  # N/m; m, to either side
INPUT = Input("place", "rail", 0.25)


def spring() -> LearnedForce:
    """−k q, as known of |q| ≤ 0.5 m."""
    places = np.linspace(-REACH, REACH, 400)[:, None]
    points = features((INPUT,), block().nominal(), Seen(places, places, places))
    basis = around((INPUT,), points, 24, 1.0)
    weights = np.asarray(np.linalg.lstsq(basis.functions(points), -STIFFNESS * places[:, 0])[0], np.float64)
    return LearnedForce(basis, basis.coefficients(weights), "N")


def learned() -> PlacedEffect:
    return place(ResidualForce(2.0, {"rail": spring()}), block().nominal(), "rail", scales_of(block()))


@pytest.mark.parametrize(("factor", "rate"), [(1.0, 3.0), (0.25, 1.5), (0.0, 0.0)])
def test_a_learned_spring_swings(factor: float, rate: float) -> None:
    time, rollout = played(block(), learned(), {"factor": factor}, 1.0, start=(0.1, 0.0))
    np.testing.assert_allclose(rollout.qpos[0, :, 0], 0.1 * np.cos(rate * time), atol=1e-3)


def test_beyond_what_was_seen_nothing_acts() -> None:
    time, rollout = played(block(), learned(), {"factor": 1.0}, 0.5, start=(2.0, 0.3))
    np.testing.assert_allclose(rollout.qpos[0, :, 0], 2.0 + 0.3 * time, rtol=0, atol=1e-12)
    places = np.linspace(-4.0, 4.0, 801)[:, None]
    force = spring().of(block().nominal(), Seen(places, places, places))
    outside = np.abs(places[:, 0]) > REACH + 0.25 * spring().basis.far
    assert (force[outside] == 0.0).all()
    inside = np.abs(places[:, 0]) <= REACH
    np.testing.assert_allclose(force[inside], -STIFFNESS * places[inside, 0], atol=0.05)


def test_it_sits_where_something_was_learned() -> None:
    assert residual_force(2.0).sites(block().nominal()) == ()
    with pytest.raises(UnknownNameError, match="site for residual_force"):
        place(residual_force(2.0), block().nominal(), "rail", scales_of(block()))


def test_a_run_keeps_it_and_the_file_says_what_model_xml_lacks(tmp_path: Path) -> None:
    model = block().with_effect(learned())
    z = model.space.vector({"residual_force@rail.factor": 0.8})
    write_context(tmp_path / "context.yaml", ContextEstimate(model.space, z, 0.01 * np.eye(1)))
    write_learned_forces(tmp_path, learned_forces(model))
    found = from_run(str(tmp_path), block(), {})
    np.testing.assert_array_equal(found.space.nominal, [0.8])
    np.testing.assert_array_equal(found.space.high, [2.0])
    places = np.linspace(-1.0, 1.0, 50)[:, None]
    first, again = (
        learned_forces(each)["rail"].of(block().nominal(), Seen(places, places, places)) for each in (model, found)
    )
    np.testing.assert_array_equal(first, again)
    (lacks,) = inexpressible(found, found.space.nominal)
    assert "residual_force.json" in lacks
    assert "model=from_run" in lacks
    assert residual_force(2.0, str(tmp_path)).sites(block().nominal()) == ("rail",)


def test_other_files_are_refused(tmp_path: Path) -> None:
    assert read_learned_forces(tmp_path) == {}
    for content in ("{", "[]", '{"schema": "other", "forces": {"rail": {}}}'):
        (tmp_path / FILE).write_text(content)
        with pytest.raises(ConfigError, match="expected schema dr_lab/residual_force/1"):
            read_learned_forces(tmp_path)
