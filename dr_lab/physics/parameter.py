"""A simulation parameter: one scalar of the physics that may be identified or randomised."""

from dataclasses import dataclass

import numpy as np

from dr_lab.errors import ModelError

AT_A_BOUND = 1e-3  # widths of the bounds, within which a value counts as at one


@dataclass(frozen=True)
class Parameter:
    """One scalar of the physics.

    Attributes:
        name: unique name, ``"arm.mass"`` or ``"coulomb_friction@arm.torque"``.
        unit: SI unit of the value.
        nominal: value of the uncorrected model; for an effect's parameter the value at which the effect is absent.
        low: smallest admissible value.
        high: largest admissible value, > low.
        prior: standard deviation of a fit's weak prior around nominal, in widths of the bounds; None for the one that
            all parameters have (solver.prior_spans).

    Raises:
        ModelError: the bounds are not finite and ordered, or nominal lies outside them.
    """

    name: str
    unit: str
    nominal: float
    low: float
    high: float
    prior: float | None = None

    def __post_init__(self) -> None:
        if not (np.isfinite([self.low, self.nominal, self.high]).all() and self.low < self.high):
            raise ModelError(
                f"Parameter {self.name!r}: bounds [{self.low}, {self.high}] with nominal {self.nominal} "
                "must be finite and ordered low < high. Correct them in the model's or effect's yaml."
            )
        if not self.low <= self.nominal <= self.high:
            raise ModelError(
                f"Parameter {self.name!r}: nominal {self.nominal:g} {self.unit} lies outside "
                f"[{self.low:g}, {self.high:g}]. Widen the bounds in the yaml, or correct the value in the MJCF."
            )

    @property
    def span(self) -> float:
        """Width of the bounds, high − low, in `unit`."""
        return self.high - self.low

    def ends(self, value: float) -> tuple[bool, bool]:
        """Whether a value lies at the lower and at the upper bound, as fits end there, whose steps are of the width."""
        near = AT_A_BOUND * self.span
        return value - self.low < near, self.high - value < near

    def touches(self, value: float) -> tuple[bool, bool]:
        """The same to a reader, to whom bounds of one sign may be orders of magnitude apart.

        A share of their width would hold many times the smaller one, so a share of their ratio counts.
        """
        return value - self.low < _near(self.low, self.high), self.high - value < _near(self.high, self.low)


def _near(bound: float, other: float) -> float:
    """How near to a bound a value touches it."""
    if abs(bound) < abs(other) and bound * other > 0:
        return abs(bound) * ((other / bound) ** AT_A_BOUND - 1)
    return AT_A_BOUND * abs(other - bound)
