"""The formula that a run's report has of a force that is still missing, as `effects.formula` takes it."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

from omegaconf import DictConfig, ListConfig, OmegaConf

from dr_lab.errors import ConfigError

if TYPE_CHECKING:
    from dr_lab.reports.force_entries import ForceFormulaEntry


def found_formula(
    run: str | None, joint: str | None, key: str, reach: float = math.inf
) -> str | DictConfig | ListConfig:
    """A key of `effects.formula`; the resolver ``${found_formula:FOLDER,arm,free,3.0}``.

    Each term has a parameter of its own, k1, k2, …, whose nominal value is 0 and whose start is the report's.

    Args:
        run: the run folder; None where the user gives the formula.
        joint: at which the force is missing.
        key: ``expression``, ``free`` or ``start``.
        reach: bounds of a parameter, in sizes of its value; only ``free`` has any.

    Raises:
        ConfigError: no run or no joint is given, or the run's report has no formula for the joint.
        DataError: the report cannot be read.
    """
    if run is None and key == "start":
        return OmegaConf.create([])
    if run is None:
        raise ConfigError(
            "effect=formula needs a formula. Give effects.formula.expression and effects.formula.free, or "
            "effect.run=FOLDER of a run whose report.md has one for the joint."
        )
    terms = _formula(Path(run).expanduser(), joint).terms
    names = [f"k{place}" for place in range(1, len(terms) + 1)]
    if key == "expression":
        return " + ".join(f"{name} * ({term.expression})" for name, term in zip(names, terms, strict=True))
    values = {name: float(term.coefficient or 0.0) for name, term in zip(names, terms, strict=True)}
    if key == "start":
        return OmegaConf.create([values])
    return OmegaConf.create(
        {
            name: {"unit": term.unit, "nominal": 0.0, "low": -reach * abs(value), "high": reach * abs(value)}
            for (name, value), term in zip(values.items(), terms, strict=True)
        }
    )


def _formula(folder: Path, joint: str | None) -> "ForceFormulaEntry":
    from dr_lab.reports.report import read_gap  # noqa: PLC0415  NumPy takes a tenth of a second, which --help would pay

    report = read_gap(folder, "effect.run")
    found = {row.joint: row.left for row in report.judged.missing_force if row.left and row.left.terms}
    listed = ", ".join(f"effect.joint={name}" for name in found) or "none"
    if joint not in found:
        raise ConfigError(
            f"The report of effect.run={folder} has no formula for effect.joint={joint}. Available: {listed}."
        )
    left = found[joint]
    if not all(term.expression for term in left.terms):
        raise ConfigError(
            f"The report of effect.run={folder} is of an older dr_lab. Run it again, or type the formula."
        )
    return left
