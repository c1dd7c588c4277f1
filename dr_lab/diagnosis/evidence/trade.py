"""What the rest of a model makes up for, where one effect stands in the place of another."""

from dataclasses import dataclass

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.fit.normal_equations import inverse_root
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Trade:
    """One parameter that two explanations of the same logs see differently.

    Attributes:
        name: the parameter, which both models have.
        unit: its unit.
        first: its value beside the one effect.
        second: its value beside the other.
    """

    name: str
    unit: str
    first: float
    second: float


def trades(first: FittedModel, second: FittedModel, settings: EvidenceSettings) -> tuple[Trade, ...]:
    """Parameters that trade against the last effects of two models, the most telling first.

    Both models are one model with one effect each on top of it. A parameter of that model trades where its fitted
    values differ by (Δz)²/(σ₁² + σ₂²) above the threshold of evidence, σ being the formal standard deviations.
    """
    shared = len(first.model.space.names) - len(first.model.effects[-1].parameters)
    gap = first.fit.z[:shared] - second.fit.z[:shared]
    apart = gap**2 / (_variance(first)[:shared] + _variance(second)[:shared])
    order = sorted((k for k in range(shared) if apart[k] > settings.threshold), key=lambda k: -apart[k])
    parameters = first.model.space.parameters
    return tuple(
        Trade(parameters[k].name, parameters[k].unit, float(first.fit.z[k]), float(second.fit.z[k])) for k in order
    )


def _variance(fitted_model: FittedModel) -> Array:
    """Formal variance of every parameter of a fit, in its own unit."""
    information, _ = fitted_model.fit.equations.window_information()
    root = inverse_root(information.sum(0), fitted_model.fit.equations.prior)
    return (root**2).sum(1) * fitted_model.model.space.span**2
