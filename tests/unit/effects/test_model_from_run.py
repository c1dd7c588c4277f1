"""The model that a run ended with, put together again from its folder."""

from pathlib import Path

import numpy as np
import pytest
from effect_machines import block, catalogue_effect, placed

from dr_lab.comparison.export import write_context
from dr_lab.effects.from_run import from_run
from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.physics.context import ContextEstimate
from dr_lab.physics.model import Model, from_spec

EFFECTS = {name: catalogue_effect(name) for name in ("viscous_friction", "spring", "end_stop")}


def left_by_a_run(folder: Path, model: Model, values: dict[str, float]) -> None:
    mean = model.space.vector(values)
    write_context(folder / "context.yaml", ContextEstimate(model.space, mean, 0.01 * np.eye(len(mean))))


def test_its_nominal_is_what_was_fitted_and_its_bounds_are_the_runs(tmp_path: Path) -> None:
    truth = block().with_effect(placed(block(), "viscous_friction", "rail"))
    left_by_a_run(tmp_path, truth, {"viscous_friction@rail.coefficient": 0.7})
    found = from_run(str(tmp_path), block(), EFFECTS)
    assert found.nominal().dof_damping[0] == 0.7
    assert found.space.names == truth.space.names
    np.testing.assert_array_equal(found.space.high, truth.space.high)


def test_an_end_stop_that_a_run_found_is_read_back(tmp_path: Path) -> None:
    truth = block().with_effect(placed(block(), "end_stop", "rail"))
    left_by_a_run(tmp_path, truth, {"end_stop@rail.upper": 0.1})
    found = from_run(str(tmp_path), block(), EFFECTS)
    assert found.nominal().jnt_range[0, 1] == 0.1
    for ends in ("low", "high"):
        np.testing.assert_array_equal(getattr(found.space, ends), getattr(truth.space, ends))


def test_a_calibrated_model_moves_as_calibrated(tmp_path: Path) -> None:
    mass = {"block.mass": {"target": "body.block.mass", "unit": "kg", "low": 1.0, "high": 4.0}}
    model = from_spec("block", block().spec, mass)
    left_by_a_run(tmp_path, model, {"block.mass": 2.5})
    found = from_run(str(tmp_path), model, {})
    assert found.nominal().body("block").mass[0] == 2.5
    np.testing.assert_array_equal(found.compile(np.array([2.0])).body_mass, model.nominal().body_mass)


def test_a_model_that_the_run_did_not_begin_with_is_refused(tmp_path: Path) -> None:
    left_by_a_run(tmp_path, block().with_effect(placed(block(), "spring", "rail")), {})
    already = block().with_effect(placed(block(), "viscous_friction", "rail"))
    with pytest.raises(UnknownNameError, match=r"viscous_friction@rail\.coefficient"):
        from_run(str(tmp_path), already, EFFECTS)
    with pytest.raises(ConfigError, match=r"There is no folder .*/nowhere\. Give the folder of a run of dr-lab close"):
        from_run(str(tmp_path / "nowhere"), block(), EFFECTS)
    (tmp_path / "empty").mkdir()
    with pytest.raises(ConfigError, match=r"has no context\.yaml"):
        from_run(str(tmp_path / "empty"), block(), EFFECTS)
