"""What the recordings show: the scored logs, measured and simulated before and after."""

from collections.abc import Mapping
from dataclasses import replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.comparison.export import Played, play
from dr_lab.comparison.force_maps import force_maps
from dr_lab.comparison.study import Study
from dr_lab.diagnosis.missing_force.residual_force import ResidualForce
from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.channels import residual as channel_residual
from dr_lab.diagnosis.windows.channels import resolve
from dr_lab.diagnosis.windows.windows import cut, window_begins
from dr_lab.effects.joint_effect import drives, slides
from dr_lab.effects.learned_force import LearnedForce
from dr_lab.effects.residual_force import ResidualForce as LearnedEffect
from dr_lab.effects.residual_force import learned_forces
from dr_lab.measurements.smoothing import local_polynomial
from dr_lab.physics.model import Model
from dr_lab.physics.radial_basis import Seen
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import AFTER, MEASURED, Overlay
from dr_lab.recorders.scene import body_poses
from dr_lab.reports.quantity import titled
from dr_lab.trajectory import Array, Log

_EVERY_WINDOW = 1e9  # s

Forces = Mapping[str, Mapping[str, ResidualForce]]  # by role and joint


def shown_logs(study: Study, longest: float) -> tuple[Log, ...]:
    """Logs that recordings show: the held-out ones, or the fit logs where none is held out, if they hold a window.

    Of longer logs their first `longest` seconds, so that a recording of hours takes no more memory than one of minutes;
    where no window lies in these, because commands begin later, as many seconds from the first window on.
    """
    logs = study.measurements.held_out or study.measurements.fit
    held = set(study.predicted.logs) & set(study.short.logs)
    parts = (_beginning(study, log, longest) for log in logs if log.name in held)
    return tuple(part for part in parts if part is not None)


def play_log(study: Study, log: Log, models: Mapping[str, tuple[Model, Array]]) -> dict[str, Played]:
    """Play a log by role, in predicted windows that follow one another without a gap."""
    settings = _one_after_another(study, study.settings.predicted.length)
    windows = cut([log], study.measurements, study.compiled, settings)
    return {role: play(study, model, z, windows) for role, (model, z) in models.items()}


def missing(study: Study, models: Mapping[str, tuple[Model, Array]]) -> Forces:
    """What models miss at each joint in short windows of the scored logs, by role and joint."""
    return {role: study.fits.forces(model, z, study.short, study.few) for role, (model, z) in models.items()}


def overlay(study: Study, log: Log, played: Mapping[str, Played], forces: Forces, look: Look) -> Overlay:
    """Everything that the recording shows of one log; forces as `missing` gives them."""
    time, poses = _poses(study, log, played, look)
    of_log = study.short.log[study.few] == study.short.logs.index(log.name)
    joints = next(iter(forces.values())).keys() if forces else ()
    seen, learned = _seen(study, forces, of_log), _learned(played, forces)
    return Overlay(
        log=log.name,
        time=time,
        poses=poses,
        measured=log.outputs,
        simulated={role: at_samples(log, p) for role, p in played.items()},
        residual_velocity={
            joint: (
                _shown(forces, joint, next(iter(forces.values()))[joint].velocity)[of_log],
                {role: f[joint].force[of_log] for role, f in forces.items()},
            )
            for joint in joints
        },
        arguments={joint: _arguments(study, log, joint, forces) for joint in joints},
        commands=log.commands,
        noise={name: study.measurements.noise[name].std for name in log.outputs},
        gaps=study.measurements.gaps,
        learned={joint: factor * force.of(study.compiled, seen) for joint, (force, factor) in learned.items()},
        force_maps=force_maps(study.compiled, learned, seen),
        residual_names={j: f"missing force [{'N' if slides(study.compiled, j) else 'N·m'}]" for j in joints},
        starts=_starts(study, played),
    )


def _learned(played: Mapping[str, Played], forces: Forces) -> dict[str, tuple[LearnedForce, float]]:
    """The learned forces of the improved model and the factors on them, by joint whose missing force is known."""
    if AFTER not in played:
        return {}
    model = played[AFTER].replay.model
    values, found = model.values(played[AFTER].fit.z[None]), learned_forces(model)
    factors = {each.site: each.local(values) for each in model.effects if isinstance(each.effect, LearnedEffect)}
    return {
        joint: (force, float(factors[joint]["factor"][0])) for joint, force in found.items() if joint in forces[AFTER]
    }


def _seen(study: Study, forces: Forces, of_log: NDArray[np.bool_]) -> Seen:
    """The states in the middle of a log's short windows, at the model's pose where nothing is known of a joint."""
    model, windows = study.compiled, study.short.pick(study.few)
    seen = seen_in_the_middle(model, [{}, *forces.values()][-1], windows.controls.mean(1))
    return Seen(*(values[of_log] for values in seen))


def seen_in_the_middle(model: mujoco.MjModel, forces: Mapping[str, ResidualForce], controls: Array) -> Seen:
    """States in the middle of windows with such controls (w, nu); joints without a force rest at the model's pose.

    They are NaN where the force is, in windows that diverge.
    """
    seen = Seen(np.tile(model.qpos0, (len(controls), 1)), np.zeros((len(controls), model.nv)), controls)
    for joint, force in forces.items():
        known = np.isfinite(force.force)
        seen.qpos[:, model.joint(joint).qposadr[0]] = np.where(known, force.position, np.nan)
        seen.qvel[:, model.joint(joint).dofadr[0]] = np.where(known, force.velocity, np.nan)
    return seen


def _shown(forces: Forces, joint: str, values: Array) -> Array:
    """Values (w,) of windows that some model simulates; NaN of the others, in which motion is that of a divergence."""
    known = np.any([np.isfinite(of_role[joint].force) for of_role in forces.values()], axis=0)
    return np.where(known, values, np.nan)


def _arguments(study: Study, log: Log, joint: str, forces: Forces) -> dict[str, Array]:
    """What a missing force may be a function of in the short windows of a log.

    Velocity, position, and the commands of the joint's own actuators, or all where it has none.
    """
    of_log = study.short.log[study.few] == study.short.logs.index(log.name)
    unit, windows = "m" if slides(study.compiled, joint) else "rad", study.short.pick(study.few)
    force = next(iter(forces.values()))[joint]
    moved = {f"velocity of {joint} [{unit}/s]": force.velocity, f"position of {joint} [{unit}]": force.position}
    columns = {name: windows.commands[name] for name in log.commands}
    own = drives(study.compiled, joint)
    asked = {
        titled(f"command {name}", log.commands[name].unit): windows.controls[..., column].mean(1)
        for name, column in columns.items()
        if own[column] or not own[[*columns.values()]].any()
    }
    return {title: _shown(forces, joint, value)[of_log] for title, value in (moved | asked).items()}


def at_samples(log: Log, played: Played) -> dict[str, Array]:
    """Simulated channels at the measured times of a log, NaN between windows."""
    values = {name: np.full_like(signal.value, np.nan) for name, signal in log.outputs.items()}
    for samples in played.replay.windows.samples:
        name = samples.channel.name
        simulated = played.replay.reading(played.fit.z[None], played.tape, samples.channel)(samples.time[None])[0]
        times = samples.time + played.replay.windows.begin[:, None]
        shown = samples.scored & ~played.fit.infeasible[:, None]
        index = np.searchsorted(log.outputs[name].time, times[shown] - 1e-9)
        values[name][index] = simulated[shown].reshape(-1, *values[name].shape[1:])
    return values


def residuals(log: Log, study: Study, simulated: Mapping[str, Array]) -> dict[str, Array]:
    """Measured − simulated of each channel at the measured times, in the channel's unit."""
    found = {}
    for channel in resolve(study.compiled, tuple(log.outputs)):
        measured = log.outputs[channel.name].value
        rows = (measured.reshape(1, len(measured), -1), simulated[channel.name].reshape(1, 1, len(measured), -1))
        found[channel.name] = channel_residual(channel, rows[1], rows[0])[0, 0]
    return found


def _beginning(study: Study, log: Log, seconds: float) -> Log | None:
    """The log up to so many seconds after its first sample, or its first window; None if neither can be played."""
    sample = min(signal.time[0] for signal in log.outputs.values())
    window = study.predicted.begin[study.predicted.log == study.predicted.logs.index(log.name)].min()
    parts = (_until(log, start + seconds) for start in (sample, window))
    return next((part for part in parts if _is_playable(study, part)), None)


def _until(log: Log, end: float) -> Log:
    outputs, commands = (
        {name: replace(s, time=s.time[s.time <= end], value=s.value[s.time <= end]) for name, s in signals.items()}
        for signals in (log.outputs, log.commands)
    )
    return replace(log, outputs=outputs, commands=commands)


def _is_playable(study: Study, log: Log) -> bool:
    if not all(map(len, (*log.outputs.values(), *log.commands.values()))):
        return False
    settings = _one_after_another(study, study.settings.predicted.length)
    return len(window_begins(log, study.measurements.gaps, settings)) > 0


def _one_after_another(study: Study, length: float) -> WindowSettings:
    return replace(study.settings.predicted.of_length(length), seconds=_EVERY_WINDOW)


def _poses(
    study: Study, log: Log, played: Mapping[str, Played], look: Look
) -> tuple[Array, dict[str, tuple[Array, Array]]]:
    """Body poses of the measured and of each simulated robot at even times that windows cover."""
    model = study.compiled
    lead = study.settings.predicted.run_in + study.settings.predicted.margin
    count = max(1, int(study.settings.predicted.length * look.pose_rate))
    offsets = np.arange(count) / look.pose_rate
    time = (_starts(study, played)[:, None] + offsets).ravel()
    measured = np.tile(model.qpos0, (len(time), 1))
    for channel in resolve(model, tuple(log.outputs)):
        if channel.kind == "position":
            measured[:, channel.address] = local_polynomial(
                log.outputs[channel.name], time, study.settings.windows.smoother
            ).value
    poses = {MEASURED: _kinematics(model, model, measured)}
    for role, part in played.items():
        steps = np.rint((lead + offsets) / part.replay.windows.step).astype(int)
        qpos = part.tape.qpos[0][:, steps].reshape(len(time), -1)
        place, turn = _kinematics(part.replay.model.compile(part.fit.z), model, qpos)
        place[np.repeat(part.fit.infeasible, count)] = np.nan  # MuJoCo begins anew where a window diverges
        poses[role] = place, turn
    return time, poses


def _starts(study: Study, played: Mapping[str, Played]) -> Array:
    """Times of a log at which windows begin that are shown, s; increasing, as the windows follow one another."""
    lead = study.settings.predicted.run_in + study.settings.predicted.margin
    return next(iter(played.values())).replay.windows.begin + lead


def _kinematics(model: mujoco.MjModel, geometry: mujoco.MjModel, qpos: Array) -> tuple[Array, Array]:
    """World poses of the geometry's bodies, positions (n, nbody, 3) and quaternions (n, nbody, 4)."""
    return body_poses(model, qpos, [model.body(geometry.body(i).name).id for i in range(geometry.nbody)])
