"""What no effect explains: a sparse formula of the missing force, and what a forest foretells of it from the state."""

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from dr_lab.bounds import Count, Natural, Positive, at_least, require_bounds
from dr_lab.trajectory import Array

Groups = NDArray[np.intp]


@dataclass(frozen=True)
class FormulaSettings:
    """How a formula is looked for.

    Attributes:
        terms: most terms of a formula.
        harmonics: multiples of an angle whose sine and cosine are terms.
        folds: parts of the logs that are predicted from the others.
        parts: logs, or pieces of them where they are fewer, that stay together in a fold.
        worth: share of the force's mean square that a further term must explain of the parts left out.
        least: number of windows below which nothing is said.
        windows: number of windows that forces are looked for in at most.
        pushes: most pushes of one degree of freedom in one of them; machines with many look at fewer windows.
        trees: of the forest that estimates from below how much a function of the state could explain.

    Raises:
        ConfigError: a number is too small.
    """

    terms: Count
    harmonics: Natural
    folds: Annotated[int, at_least(2)]
    parts: Annotated[int, at_least(2)]
    worth: Positive
    least: Annotated[int, at_least(2)]
    windows: Count
    pushes: Count
    trees: Count

    def __post_init__(self) -> None:
        require_bounds(self, "localise.formula")

    def windows_of(self, dofs: int) -> int:
        """In how many windows forces are looked for, of a machine with so many degrees of freedom; `least` at least."""
        return min(self.windows, max(self.least, self.pushes // max(dofs, 1)))


@dataclass(frozen=True)
class Variable:
    """One quantity that a force may depend on, over n windows.

    Attributes:
        name: as ``q`` of a joint in words, e.g. ``arm velocity``.
        unit: its unit.
        kind: ``angle``, ``place``, ``velocity`` or ``command``.
        value: shape (n,).
        symbol: what `effects.formula` calls it, e.g. ``arm.v``.
    """

    name: str
    unit: str
    kind: str
    value: Array
    symbol: str


@dataclass(frozen=True)
class Formula:
    """A sparse formula of a force.

    Attributes:
        coefficients: by term, in `unit` per the term's unit.
        units: unit of each coefficient.
        expressions: each term as `effects.formula` takes it, e.g. ``sign(arm.v)``.
        share: share of the force's mean square that it explains where it was not fitted.
        ceiling: the same of a regression forest on the same variables.
    """

    coefficients: Mapping[str, float]
    units: Mapping[str, str]
    expressions: Mapping[str, str]
    share: float
    ceiling: float


def sparse_formula(
    force: Array, unit: str, variables: Sequence[Variable], groups: Groups, settings: FormulaSettings
) -> Formula | None:
    """Orthogonal matching pursuit over a library of terms, as long as further terms predict logs left out better.

    F ≈ Σ_k c_k f_k with f_k among 1; v, sign(v), |v| v, v³; sin(m q), cos(m q) of angles; x, x³ of places; u of
    commands. Shares are 1 − Σ(F − F̂)²/Σ F² with every F̂ predicted from the other folds.

    Args:
        force: missing force of n windows, shape (n,); windows without one are NaN.
        unit: its unit.
        variables: what it may depend on.
        groups: log of each window, or another part of the data that is left out together, shape (n,).
        settings: how long the formula may be.

    Returns:
        The formula; None where there are too few windows, or fewer groups than two.

    Source: Pati, Rezaiifar and Krishnaprasad, Asilomar 1993 (the pursuit); Brunton, Proctor and Kutz, PNAS 113 (2016)
    for libraries of terms.
    """
    # scikit-learn takes longer to import than all the rest of a verb; only what looks for formulas waits for it.
    from dr_lab.diagnosis.missing_force.regressors import Pursuit, forest, left_out  # noqa: PLC0415

    known = np.isfinite(force)
    if known.sum() < settings.least or len(np.unique(groups[known])) < 2:
        return None
    force, groups = force[known], groups[known]
    kept = [replace(v, value=v.value[known]) for v in variables]
    terms = [term for term in _library(kept, settings.harmonics) if np.ptp(term.value) > 0 or term.name == "1"]
    columns = np.stack([term.value for term in terms], axis=1)
    folds = min(settings.folds, len(np.unique(groups)))
    tried = (left_out(Pursuit(size), columns, force, groups, folds) for size in range(1, columns.shape[1] + 1))
    share, count = _pursued(force, itertools.islice(tried, settings.terms), settings.worth)
    features = np.stack([v.value for v in kept], axis=1)
    ceiling = _explained(force, left_out(forest(settings.trees), features, force, groups, folds))
    coefficients = Pursuit(count).fit(columns, force).coef_ if count else np.zeros(columns.shape[1])
    return _written(unit, terms, coefficients, share, max(ceiling, share))


def _written(unit: str, terms: Sequence["_Term"], coefficients: Array, share: float, ceiling: float) -> Formula:
    chosen = [(term, float(c)) for term, c in zip(terms, coefficients, strict=True) if c != 0]
    return Formula(
        coefficients={term.name: c for term, c in chosen},
        units={term.name: f"{unit}/({term.unit})" if term.unit else unit for term, _ in chosen},
        expressions={term.name: term.expression for term, _ in chosen},
        share=share,
        ceiling=ceiling,
    )


def mean_square(force: Array) -> float:
    """Mean square of a force over the windows that have one."""
    return float(np.nanmean(force**2))


@dataclass(frozen=True)
class _Term:
    name: str
    unit: str
    value: Array
    expression: str


def _library(variables: Sequence[Variable], harmonics: int) -> list[_Term]:
    terms = [_Term("1", "", np.ones(len(variables[0].value)), "1")]
    for v in variables:
        name, x, s = f"[{v.name}]", v.value, v.symbol
        if v.kind == "angle":
            for m in range(1, harmonics + 1):
                inside, within = (name, s) if m == 1 else (f"{m} {name}", f"{m} * {s}")
                terms.append(_Term(f"sin({inside})", "", np.sin(m * x), f"sin({within})"))
                terms.append(_Term(f"cos({inside})", "", np.cos(m * x), f"cos({within})"))
            continue
        terms.append(_Term(name, v.unit, x, s))
        if v.kind == "velocity":
            terms.append(_Term(f"sign({name})", "", np.sign(x), f"sign({s})"))
            terms.append(_Term(f"|{name}| {name}", f"({v.unit})²", np.abs(x) * x, f"abs({s}) * {s}"))
        if v.kind in ("place", "velocity"):
            terms.append(_Term(f"{name}³", f"({v.unit})³", x**3, f"{s}**3"))
    return terms


def _pursued(force: Array, tried: Iterable[Array], worth: float) -> tuple[float, int]:
    """Share of the force that a prediction explains and its number of terms, up to the first that is not worth one."""
    share, count = 0.0, 0
    for size, predicted in enumerate(tried, start=1):
        reached = _explained(force, predicted)
        if reached < share + worth:
            break
        share, count = reached, size
        if share > 1.0 - worth:
            break
    return share, count


def _explained(force: Array, predicted: Array) -> float:
    return 1.0 - float(((force - predicted) ** 2).sum() / (force**2).sum())
