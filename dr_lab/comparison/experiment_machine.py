"""The machine of a study as the next experiment finds it: what it did in its logs, and what it must keep."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from dr_lab.comparison.study import Study
from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.next_experiment.clearance import Clearance
from dr_lab.diagnosis.next_experiment.family import Bounds
from dr_lab.diagnosis.next_experiment.held_commands import held_standing
from dr_lab.diagnosis.next_experiment.limits import Limits, Shown, close_pairs
from dr_lab.diagnosis.next_experiment.machine import ExperimentMachine
from dr_lab.diagnosis.next_experiment.ranges import command_ranges, slews
from dr_lab.diagnosis.next_experiment.settings import ExperimentSettings
from dr_lab.diagnosis.next_experiment.standing import Standing, first_pose
from dr_lab.diagnosis.next_experiment.trial import forces, watched
from dr_lab.seeding import stream
from dr_lab.trajectory import Array, Log, Signal


def experiment_machine(
    study: Study, fitted_model: FittedModel, settings: ExperimentSettings
) -> tuple[ExperimentMachine, Standing] | None:
    """What experiments on the machine of a study may do, by a model that was fitted to it; None without a command."""
    model, z, safety = fitted_model.model, fitted_model.fit.z, settings.safety
    compiled, names = study.compiled, tuple(study.bench.fit.commands)
    logs = (*study.measurements.fit, *study.measurements.held_out)
    clearance = Clearance(model, z, 4 * safety.clearance, study.bench.threads)
    shown = _shown(study, fitted_model, clearance, logs, settings.log_look)
    limits = Limits.of(compiled, shown, safety)
    steady = clearance.steady(*_ends(limits, shown), stream(settings.seed, "clearance"))
    shown = replace(shown, distance=np.where(steady, 0.0, shown.distance))  # no motion brings these closer
    sent = {name: _sent([log.commands[name] for log in logs if name in log.commands]) for name in names}
    ranges = command_ranges(compiled, limits, sent, safety)
    if not ranges:
        return None
    at_rest = held_standing(model, z, first_pose(compiled, logs), ranges, settings.stillness)
    low, high = np.array(list(ranges.values())).T
    kept = limits.within(safety, at_rest.qpos, shown)
    machine = ExperimentMachine(
        start=at_rest.qpos,
        names=tuple(ranges),
        bounds=Bounds(np.array(list(at_rest.hold.values())), low, high, slews(compiled, kept, tuple(ranges))),
        kept=kept,
        clearance=clearance,
        noise={name: study.measurements.noise[name] for name in study.measurements.fit[0].outputs},
        windows=study.settings.windows,
        solver=study.bench.solver,
        command_rate=_rate([log.commands for log in logs], settings.command_rate),
        sample_rate=_rate([log.outputs for log in logs], settings.sample_rate),
        longest_window=settings.longest_window,
        threads=study.bench.threads,
    )
    return machine, at_rest


def _ends(limits: Limits, shown: Shown) -> tuple[Array, Array]:
    """Ends of what each position may be; the logs' where nothing bounds it."""
    bounded = np.isfinite(limits.low) & np.isfinite(limits.high)
    return np.where(bounded, limits.low, shown.low), np.where(bounded, limits.high, shown.high)


def _shown(study: Study, fitted_model: FittedModel, clearance: Clearance, logs: Sequence[Log], look: float) -> Shown:
    """What the machine did: its measured positions, and in all windows the motion of the fitted model."""
    model = watched(fitted_model.model)
    replay = Replay(model, study.bench.fit, study.bench.threads)
    tape, infeasible = replay.simulate(fitted_model.fit.z[None], fitted_model.fit.delta[None])
    rows = ~infeasible[0]
    qpos, qvel = tape.qpos[0][rows], tape.qvel[0][rows]
    force = np.abs(forces(model, tape.sensordata[0][rows]))
    every = max(1, round(look / tape.step))
    low, high = qpos.min(axis=(0, 1)), qpos.max(axis=(0, 1))
    _widen(study, logs, low, high)
    return Shown(
        low=low,
        high=high,
        speed=np.abs(qvel).max(axis=(0, 1)),
        force=force.max(axis=(0, 1)),
        distance=close_pairs(clearance, qpos[:, ::every]).min(axis=0),
    )


def _widen(study: Study, logs: Sequence[Log], low: Array, high: Array) -> None:
    """Take in what was measured of the joints' positions."""
    for samples in study.bench.fit.samples:
        channel = samples.channel
        if channel.kind == "position":
            values = [log.outputs[channel.name].value for log in logs if channel.name in log.outputs]
            low[channel.address] = min(low[channel.address], *(float(value.min()) for value in values))
            high[channel.address] = max(high[channel.address], *(float(value.max()) for value in values))


def _sent(commands: Sequence[Signal]) -> tuple[float, float]:
    """Lowest and highest command of the logs."""
    return min(float(each.value.min()) for each in commands), max(float(each.value.max()) for each in commands)


def _rate(signals: Sequence[Mapping[str, Signal]], most: float) -> float:
    """Samples a second, Hz: of each channel the usual ones of the log that has most, of the slowest channel; or `most`.

    A log in which a command hardly changes, as where a machine swings freely, may hold few samples of it.
    """
    fastest: dict[str, float] = {}
    for name, each in ((name, each) for log in signals for name, each in log.items() if len(each) > 1):
        fastest[name] = max(fastest.get(name, 0.0), 1 / each.wait)
    return min([most, *fastest.values()])
