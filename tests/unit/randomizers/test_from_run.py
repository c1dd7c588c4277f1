"""A run's fitted context becomes the distribution that is trained on."""

from pathlib import Path

import numpy as np
import pytest

from dr_lab.comparison.export import write_context
from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.physics.context import ContextEstimate, ContextSpace
from dr_lab.physics.parameter import Parameter
from dr_lab.randomizers.from_run import from_run

MASS = Parameter("arm.mass", "kg", 1.0, 0.5, 2.5)
FRICTION = Parameter("coulomb_friction@arm.torque", "N·m", 0.0, 0.0, 1.0)
MEAN = np.array([1.2, 0.02])
COVARIANCE = np.array([[0.01, 0.0005], [0.0005, 0.0004]])


def run_folder(folder: Path) -> Path:
    estimate = ContextEstimate(ContextSpace((MASS, FRICTION)), MEAN, COVARIANCE)
    write_context(folder / "context.yaml", estimate)
    return folder


def test_reads_what_close_wrote_in_the_order_of_the_model(tmp_path: Path) -> None:
    randomizer = from_run(ContextSpace((FRICTION, MASS)), str(run_folder(tmp_path)), clip=False)
    normal = randomizer.distribution()
    np.testing.assert_allclose(normal.mean.detach(), MEAN[::-1])
    np.testing.assert_allclose(normal.covariance_matrix.detach(), COVARIANCE[::-1, ::-1], atol=1e-9)


def test_draws_stay_admissible_where_asked(tmp_path: Path) -> None:
    space = ContextSpace((MASS, FRICTION))
    z = from_run(space, str(run_folder(tmp_path)), clip=True).sample([np.random.default_rng(0)] * 500)
    assert z[:, 1].min() == 0.0


def test_an_effect_that_the_model_lacks_is_named(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"coulomb_friction@arm\.torque.*model@env\.model=from_run"):
        from_run(ContextSpace((MASS,)), str(run_folder(tmp_path)), clip=True)


def test_a_folder_without_a_context_is_told(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"no context\.yaml"):
        from_run(ContextSpace((MASS,)), str(tmp_path), clip=True)
