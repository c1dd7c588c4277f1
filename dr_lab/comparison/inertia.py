"""What the logs know of the bodies' inertial parameters, for the report."""

import numpy as np

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.fit.base_parameters import base_parameters
from dr_lab.physics.context import ContextEstimate
from dr_lab.physics.inertial import BodyInertial
from dr_lab.reports.inertia_entries import BodyEntry, InertiaEntry
from dr_lab.trajectory import Array

_STEP = 1e-4  # of the ten numbers, in which mass and centre are smooth


def inertia_entry(fitted_model: FittedModel, estimate: ContextEstimate) -> InertiaEntry | None:
    """Numerical base parameters of a fitted model and what its bodies weigh; None where no body is free as a whole."""
    model, space = fitted_model.model, fitted_model.model.space
    if not model.inertials:
        return None
    names = [p.name for body in model.inertials for p in body.parameters]
    found = base_parameters(fitted_model.fit.equations, space.names, np.array([space.index(name) for name in names]))
    return InertiaEntry(
        parameters=found.count,
        rank=found.rank,
        known=found.known,
        condition=found.condition,
        chosen=found.chosen,
        held=found.held,
        best=found.best,
        worst=found.worst,
        bodies={body.body: _body(body, estimate) for body in model.inertials},
    )


def _body(body: BodyInertial, estimate: ContextEstimate) -> BodyEntry:
    rows = np.array([estimate.space.index(p.name) for p in body.parameters])
    mean, covariance = estimate.mean[rows], estimate.covariance[np.ix_(rows, rows)]
    slopes = (_told(body, mean + _STEP * np.eye(len(rows))) - _told(body, mean[None])) / _STEP
    std = np.sqrt(np.clip(np.diag(slopes.T @ covariance @ slopes), 0.0, None))
    value = _told(body, mean[None])[0]
    return BodyEntry(float(value[0]), float(std[0]), tuple(value[1:].tolist()), tuple(std[1:].tolist()))


def _told(body: BodyInertial, theta: Array) -> Array:
    """Mass and centre at ten numbers each, shape (n, 4)."""
    found = body.shape.at(theta)
    return np.concatenate([found.mass[:, None], found.centre], axis=1)
