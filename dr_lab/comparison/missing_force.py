"""The report's entry on missing forces: how much the effects explain, how much anything could, and a formula."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dr_lab.comparison.study import Study
from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.missing_force.force_formula import Formula, Variable, mean_square, sparse_formula
from dr_lab.diagnosis.missing_force.residual_force import ResidualForce
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.physics.expression import spelt
from dr_lab.reports.force_entries import ForceFormulaEntry, MissingForceEntry, TermEntry


def missing_forces(study: Study, models: Sequence[FittedModel]) -> tuple[MissingForceEntry, ...]:
    """Joint by joint: missing force of the first and the last model, and what is left to explain.

    Sizes are those beyond ``noise``, the root mean square that the measurements' noise alone gives the first model's
    force. ``ceiling`` is the share of its mean square that a regression forest foretells from the measured state where
    it was not fitted, a lower estimate of what a function of that state could explain; ``explained`` the share that the
    effects took away; ``left`` belongs to what the last model misses, its shares to all of that force, noise included,
    and is None where noise is most of it or windows are few. All are of ``windows`` short windows of the logs that
    score.
    """
    first, last = (study.fits.forces(m.model, m.fit.z, study.short, study.few) for m in (models[0], models[-1]))
    replay = Replay(models[-1].model, study.short.pick(study.few), study.bench.threads)
    known = [joint for joint, part in first.items() if np.isfinite(part.force).any()]
    return tuple(_entry(study, replay, joint, first, last) for joint in known)


def _entry(
    study: Study, replay: Replay, joint: str, first: dict[str, ResidualForce], last: dict[str, ResidualForce]
) -> MissingForceEntry:
    unit = "N" if replay.slides(joint) else "N·m"
    settings = study.settings.localise.formula
    groups = _groups(replay.windows, settings.parts)
    before = sparse_formula(first[joint].force, unit, _variables(replay, first), groups, settings)
    missing, left = _beyond_noise(first[joint]), _beyond_noise(last[joint])
    tells = left > _noise(last[joint])  # otherwise most of it is noise
    after = sparse_formula(last[joint].force, unit, _variables(replay, last), groups, settings) if tells else None
    reached = before.ceiling * mean_square(first[joint].force) if before else None
    return MissingForceEntry(
        joint=joint,
        windows=int(np.isfinite(first[joint].force).sum()),
        unit=unit,
        rms_first=missing**0.5,
        rms_last=left**0.5,
        noise=_noise(first[joint]) ** 0.5,
        explained=1.0 - left / missing if missing > 0 else 0.0,
        ceiling=min(reached / missing, 1.0) if reached is not None and missing > 0 else None,
        left=_left(after),
    )


def _beyond_noise(part: ResidualForce) -> float:
    """Mean square of a force without the share that the measurements' noise has in it."""
    return max(mean_square(part.force) - _noise(part), 0.0)


def _noise(part: ResidualForce) -> float:
    """Mean square that noise alone gives a force, over the windows that have one."""
    return mean_square(np.where(np.isfinite(part.force), part.noise, np.nan))


def _left(formula: Formula | None) -> ForceFormulaEntry | None:
    if formula is None:
        return None
    terms = tuple(
        TermEntry(term, value, formula.units[term], formula.expressions[term])
        for term, value in formula.coefficients.items()
    )
    return ForceFormulaEntry(formula.ceiling, formula.share, terms)


def _variables(replay: Replay, forces: dict[str, ResidualForce]) -> list[Variable]:
    """Position and velocity of the measured joints, and the commands."""
    found = []
    for joint, part in forces.items():
        slide = replay.slides(joint)
        unit, kind, symbol = "m" if slide else "rad", "place" if slide else "angle", spelt(joint)
        found.append(Variable(f"{joint} position", unit, kind, part.position, f"{symbol}.q"))
        found.append(Variable(f"{joint} velocity", f"{unit}/s", "velocity", part.velocity, f"{symbol}.v"))
    for name, column in replay.commands.items():
        command = replay.windows.controls[..., column].mean(1)
        found.append(Variable(f"{name} command", "", "command", command, f"{spelt(name)}.u"))
    return found


def _groups(windows: Windows, least: int) -> NDArray[np.intp]:
    """Parts of the data that are left out together: logs, or, so that there are so many at least, parts of them."""
    parts = -(-least // len(windows.logs))
    counts = np.bincount(windows.log, minlength=len(windows.logs))
    return np.concatenate([k * parts + np.arange(count) * parts // count for k, count in enumerate(counts)])
