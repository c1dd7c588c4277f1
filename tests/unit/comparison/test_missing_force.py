from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import pytest
from diagnosis_machines import (
    comparison_settings,
    measured,
    pendulum,
    swinging,
)

from dr_lab.comparison.comparison import Comparison
from dr_lab.comparison.missing_force import missing_forces
from dr_lab.comparison.study import prepare
from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.trajectory import Array

MASS, DAMPING = 0.5, 0.05


@dataclass(frozen=True)
class Fitted:
    """A fit of which only the context is known."""

    z: Array


def found(*dampings: float) -> Any:  # noqa: ANN401 (an entry all of whose numbers are known)
    """The entry on the hinge for models with these dampings, the logs being those of a pendulum with `DAMPING`."""
    model, nothing = pendulum(), cast(Any, None)
    logs = [swinging(f"log_{k}", model.compile(np.array([MASS, DAMPING])), k) for k in range(4)]
    study = prepare(Comparison(model, measured(logs), comparison_settings()))
    fits = [cast(Any, Fitted(np.array([MASS, damping]))) for damping in dampings]
    (entry,) = missing_forces(study, [FittedModel(model, fit, nothing, nothing) for fit in fits])
    return entry


@pytest.mark.slow
def test_noise_does_not_pass_for_a_force_that_effects_leave() -> None:
    entry = found(DAMPING - 0.005, DAMPING)
    assert entry.noise > entry.rms_first / 3  # with it, a fifth would seem left
    assert entry.explained > 0.95
    assert entry.ceiling > 0.9


@pytest.mark.slow
def test_of_a_force_far_above_the_noise_its_size_is_told() -> None:
    entry = found(0.0, DAMPING / 2)
    assert entry.rms_last == pytest.approx(entry.rms_first / 2, rel=0.02)
    assert entry.explained == pytest.approx(0.75, abs=0.02)
    assert entry.noise < 0.1 * entry.rms_last
