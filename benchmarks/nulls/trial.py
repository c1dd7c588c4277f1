"""One null: logs of a machine that lacks no candidate, diagnosed as `dr-lab diagnose` does, beside what is true."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.comparison.calibrated import calibrate
from dr_lab.comparison.comparison import Comparison, ComparisonSettings
from dr_lab.comparison.study import Study, prepare
from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fit_and_score
from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.score import Score, score_of
from dr_lab.diagnosis.evidence.support import supported
from dr_lab.diagnosis.fit.states import StateFit, fit_states
from dr_lab.diagnosis.search.rank import Candidate, rank
from dr_lab.diagnosis.search.verdict import decide
from dr_lab.diagnosis.windows.windows import Windows, cut
from dr_lab.effects.catalogue import candidates
from dr_lab.effects.effect import PlacedEffect
from dr_lab.errors import DrLabError
from dr_lab.measurements.cleaning import longest_wait
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.noise import estimate_noise
from dr_lab.trajectory import Array, Log, MeasurementSet, Noise
from nulls.machines import MACHINES, Missing, Motions, move, split

FITTED, HELD_OUT = 4, 2  # logs
CANDIDATES = ("coulomb_friction", "quadratic_drag", "spring", "actuator_delay", "saturation", "constant_offset")
_PILOT = 3.0  # noise standard deviations of model error at which its size is settled
_TRIES = 3  # of the pilot
_TOLD = 6  # windows of each further log: logs tell more than neighbouring windows


@dataclass(frozen=True)
class Null:
    """What is simulated.

    Attributes:
        machine: of `machines.MACHINES`.
        noise: of `noise.NOISES`.
        error: of `machines.ERRORS`.
        size: root mean square of the model error in the calibrated model's windows, in noise standard deviations.
        seed: of everything random.
    """

    machine: str
    noise: str
    error: str
    size: float
    seed: int


@dataclass(frozen=True)
class Compared:
    """One candidate's fit beside the model without it.

    Attributes:
        label: of the effect.
        ranked: whether the contest fitted it to all windows; else it was fitted for this table alone.
        total: evidence on held-out windows and on fitted ones as others foretell them, as Δχ².
        total_low: lower bound that is stated for it.
        supported: whether it counts.
        truth: the same evidence as expected of other logs of this machine, for as many windows.
    """

    label: str
    ranked: bool
    total: float
    total_low: float
    supported: bool
    truth: float


def judge(null: Null, truth_logs: int) -> dict[str, Any]:
    """Simulate, diagnose and compare with the truth.

    Args:
        null: what is simulated.
        truth_logs: number of further logs that tell what gain is to be expected.

    Returns:
        One row of the results: the null, the verdict, χ², the size of the model error as it came out, and the fits.
    """
    begin = time.process_time()
    measured, further = _measured(null, truth_logs)
    simulated = time.process_time()
    row = {**asdict(null), "noise_ratio": _noise_ratio(null, measured)}
    try:
        row |= _diagnosed(null, measured, further)
    except DrLabError as refusal:
        row |= {"verdict": "refused", "effects": [], "reason": str(refusal), "fits": []}
    return {**row, "cpu_s": time.process_time() - begin, "simulation_cpu_s": simulated - begin}


def _measured(null: Null, truth_logs: int) -> tuple[MeasurementSet, tuple[Log, ...]]:
    """The logs as a user has them, their noise estimated, and further logs of the same machine."""
    machine, rng = MACHINES[null.machine], np.random.default_rng(null.seed)
    size = null.size * _unit(null.machine, null.error) if null.size else 0.0
    motions = move(machine, FITTED + HELD_OUT + truth_logs, Missing(null.error, size), rng)
    logs, further = split(motions.logs(null.noise, rng), FITTED + HELD_OUT)
    contract = _contract()
    waits = {c: longest_wait([g.outputs[c].time for g in logs], contract, on_change=False) for c in logs[0].outputs}
    noise = {c: estimate_noise([g.outputs[c] for g in logs], waits[c], contract) for c in logs[0].outputs}
    fit, held_out = split(logs, FITTED)
    return MeasurementSet("null", fit, held_out, noise, waits), further


def _noise_ratio(null: Null, measured: MeasurementSet) -> float:
    """Estimated noise over the true one, root mean square over the channels."""
    return float(np.sqrt(np.mean([noise.std**2 for noise in measured.noise.values()]))) / MACHINES[null.machine].std


@cache
def _contract() -> DataContract:
    return instantiate(compose("diagnose", []).measurements.contract)


@cache
def _settings() -> ComparisonSettings:
    return instantiate(compose("diagnose", ["threads=1"]).comparison.settings, _convert_="all")


@cache
def _effects() -> Mapping[str, Any]:
    return instantiate(compose("diagnose", []).effects, _convert_="all")


@cache
def _unit(machine: str, error: str) -> float:
    """Factor of a model error that leaves one noise standard deviation with the calibrated model, in its unit."""
    made, model, settings = MACHINES[machine], MACHINES[machine].model(), _settings()
    factor = 0.03
    for _ in range(_TRIES):
        motions = move(made, FITTED, Missing(error, factor), np.random.default_rng(0))
        logs = _noiseless(motions)
        noise = {c: Noise(made.std, "rad", "given") for c in logs[0].outputs}
        measured = MeasurementSet("pilot", logs, (), noise, dict.fromkeys(logs[0].outputs, 0.1))
        windows = cut(logs, measured, model.nominal(), settings.windows)
        bench = Bench(windows, windows, settings.solver, settings.evidence, threads=1)
        left = np.sqrt(fit_and_score(bench, model, model.space.nominal).held_out.chi2)
        factor *= _PILOT / float(left)
    return factor / _PILOT


def _noiseless(motions: Motions) -> tuple[Log, ...]:
    exact = replace(motions, machine=replace(motions.machine, std=0.0))
    return tuple(exact.logs("white", np.random.default_rng(0)))


def _diagnosed(null: Null, measured: MeasurementSet, further: Sequence[Log]) -> dict[str, Any]:
    """The verdict and the fits of one set of logs."""
    machine = MACHINES[null.machine]
    study = prepare(Comparison(machine.model(), measured, _settings()))
    base = calibrate(study)
    placed = _placed(study, _effects(), null.seed)
    ranking = rank(study.bench, base, placed, lambda label: None)
    verdict = decide(ranking.base, ranking.candidates, study.bench.evidence, study.bench.scored)
    told = replace(study.settings.windows, seconds=_TOLD * study.settings.windows.length * len(further))
    judged = _Judge(study, ranking.base, cut(further, measured, study.compiled, told))
    left = np.sqrt(np.mean([value**2 for value in ranking.base.held_out.rmse.values()])) / machine.std
    return {
        "verdict": verdict.kind,
        "effects": list(verdict.effects),
        "trial": list(verdict.trial),
        "chi2": ranking.base.held_out.chi2,
        "left": float(left),
        "fits": [asdict(judged.compared(c)) for c in ranking.candidates],
    }


def _placed(study: Study, effects: Mapping[str, Any], seed: int) -> list[PlacedEffect]:
    """Every candidate at one of its sites, which differs from null to null."""
    found = []
    for k, name in enumerate(CANDIDATES):
        sites = candidates(study.model, {name: effects[name]}, study.scales, study.compiled).placed
        found += [sites[(seed + k) % len(sites)]] if sites else []
    return found


class _Judge:
    """Compares candidates with the base where the answer is known: on many further windows of the same machine."""

    def __init__(self, study: Study, base: FittedModel, further: Windows) -> None:
        self.bench, self.base, self.further = study.bench, base, further
        self.states, self.score = self._scored(base, None)
        self.share = (len(base.held_out.window_count) + len(study.bench.fit)) / len(further)

    def compared(self, candidate: Candidate) -> Compared:
        """One candidate; what the contest left unfitted is fitted from its first start."""
        ranked = candidate.fitted and candidate.final
        fitted_model = candidate.fitted_model if ranked else self._fitted(candidate.effect)
        evidence = self.bench.evidence
        gain = paired_gain(self.base.held_out, fitted_model.held_out, evidence)
        truth = 0.0  # of a fit that ended where the effect is absent
        if gain.total != 0.0:
            truth = paired_gain(self.score, self._scored(fitted_model, self.states)[1], evidence).total * self.share
        extra = len(candidate.effect.parameters)
        counts = supported(gain, extra, evidence)
        return Compared(candidate.effect.label, ranked, gain.total, gain.total_low, counts, truth)

    def _fitted(self, effect: PlacedEffect) -> FittedModel:
        model = self.base.model.with_effect(effect)
        start = {p.name: p.nominal for p in effect.parameters} | dict(effect.starts[0] if effect.starts else {})
        z: Array = np.append(self.base.fit.z, [start[p.name] for p in effect.parameters])
        return fit_and_score(self.bench, model, z, self.base.fit.delta)

    def _scored(self, fitted_model: FittedModel, near: StateFit | None) -> tuple[StateFit, Score]:
        replay, states = fit_states(fitted_model.model, fitted_model.fit.z, self.further, self.bench.solver, 1, near)
        return states, score_of(replay, states)
