"""A robot's description and its logs to a proposal: the model that is simulated, and what each series is."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco

from dr_lab.physics.compiling import compiled
from dr_lab.physics.model import Model, from_spec
from dr_lab.proposal.against import beyond
from dr_lab.proposal.counts import doubts_of_counts
from dr_lab.proposal.cut_off import cut_off
from dr_lab.proposal.drives import Command, choose_commands, commands_by_name
from dr_lab.proposal.far import far_slides
from dr_lab.proposal.freedom import Entry, free_parameters
from dr_lab.proposal.lengths import lengths_as_angles
from dr_lab.proposal.mounting import mounted
from dr_lab.proposal.moving_alike import moving_alike
from dr_lab.proposal.output import Output, Positions
from dr_lab.proposal.overlaps import overlaps
from dr_lab.proposal.positions import find_positions
from dr_lab.proposal.remaining import by_elimination
from dr_lab.proposal.robot import Robot
from dr_lab.proposal.sensor_parts import find_sensor_parts
from dr_lab.proposal.sensors import find_sensors
from dr_lab.proposal.setpoints import at_rest, counted, of_units
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.sprung import Sprung, beside_springs
from dr_lab.proposal.survey import Survey

_GIVEN = ("drive", "reference", "asked velocity")


@dataclass(frozen=True)
class Proposal:
    """What was found.

    Attributes:
        robot: as described.
        logs: what they hold.
        spec: the robot's, with what it lacked.
        changed: whether `spec` differs from the file.
        outputs: measured channels.
        commands: commands of actuators.
        parameters: what is free.
        notes: what was done to the model and why, a sentence each.
        doubts: what is unsure, a sentence each.
    """

    robot: Robot
    logs: Survey
    spec: mujoco.MjSpec
    changed: bool
    outputs: tuple[Output, ...]
    commands: tuple[Command, ...]
    parameters: Mapping[str, Entry]
    notes: tuple[str, ...]
    doubts: tuple[str, ...]

    @property
    def model(self) -> Model:
        """The model as the other verbs will load it."""
        return from_spec(self.robot.name, self.spec, self.parameters)

    @property
    def unread(self) -> tuple[str, ...]:
        """Series that neither an output nor a command reads; those that never change, and counts, say so."""
        read = {part.place for output in self.outputs for part in output.parts}
        read |= {command.series.place for command in self.commands}
        left = [each for each in self.logs.series if each.place not in read]
        said = [f"{each.place}{'' if each.moves else ' (never changes)'}" for each in left]
        return (*said, *(f"{each.place} (counts the rows)" for each in self.logs.counts))


def propose(robot: Robot, logs: Survey, settings: ProposalSettings) -> Proposal:
    """Find outputs and commands, add the actuators that are lacking, and declare what is free.

    Raises:
        DataError: the logs do not fit the robot.
    """
    spec = robot.spec.copy()
    if robot.urdf:
        spec.option.timestep, spec.option.integrator = settings.timestep, mujoco.mjtIntegrator.mjINT_RK4
    sensed = find_sensors(spec, logs, settings)
    sensed = find_sensor_parts(spec, _without(logs, sensed.outputs), sensed, settings)
    found = find_positions(compiled(spec.copy()), _without(logs, sensed.outputs), settings, sensed.outputs)
    sensed = mounted(sensed, found, settings)
    sprung = beside_springs(found.trial, found.found, settings) if found.trial and found.found else None
    commands = _commands(found, _without(logs, sensed.outputs), sprung, settings)
    added = [_add(spec, command) for command in commands if command.drive.added]
    apart = _apart(spec, found, settings)
    free = free_parameters(robot, spec, found, commands, settings)
    return Proposal(
        robot=robot,
        logs=logs,
        spec=spec,
        changed=robot.urdf or bool(sensed.notes or added or apart),
        outputs=(*found.outputs, *sensed.outputs),
        commands=commands,
        parameters=free.parameters,
        notes=(*robot.notes, *sensed.notes, *added, *apart, *free.notes),
        doubts=(
            *_of_logs(logs),
            *sensed.doubts,
            *found.doubts,
            *(sprung.doubts(robot.joints, found.found.outcome) if sprung and found.found else ()),
            *moving_alike(found.outputs, commands, logs, settings),
            *doubts_of_counts(found.outputs),
            *_of_commands(logs, found, commands, settings),
            *_beside_model(compiled(spec.copy()), found, commands, settings),
        ),
    )


def _apart(spec: mujoco.MjSpec, found: Positions, settings: ProposalSettings) -> list[str]:
    """Take the contacts of bodies out that overlap; says which."""
    overlapping = overlaps(compiled(spec.copy()), found, settings.touching)
    for a, b in overlapping:
        spec.add_exclude(bodyname1=a, bodyname2=b)
    return [f"{a} and {b} overlap in the whole motion: their contact is taken out (<exclude>)." for a, b in overlapping]


def _of_logs(logs: Survey) -> tuple[str, ...]:
    """What is unsure about the logs alone."""
    unit = logs.clock.doubt if logs.clock else ""
    clock = [f"The unit of the clock {logs.clock.axis.column}: {unit}."] if logs.clock and unit else []
    return (*clock, *logs.spoilt, *logs.doubts)


def _without(logs: Survey, outputs: Sequence[Output]) -> Survey:
    """The logs without the series that outputs read."""
    taken = {part.place for output in outputs for part in output.parts}
    return replace(logs, series=tuple(each for each in logs.series if each.place not in taken))


def _commands(found: Positions, logs: Survey, sprung: Sprung | None, settings: ProposalSettings) -> tuple[Command, ...]:
    used = {part.place for output in found.outputs for part in output.parts}
    usable = [k for k, series in enumerate(found.commands) if series.place not in used]
    if sprung is None:
        chosen = commands_by_name(found.drives, [found.commands[k] for k in usable])
    else:
        chosen = choose_commands(found.drives, found.commands, usable, sprung.outcome, settings)
    every = (*chosen, *by_elimination(found, chosen, logs, settings))
    return tuple(_as_positions(each, found, settings) for each in every)


def _as_positions(command: Command, found: Positions, settings: ProposalSettings) -> Command:
    """A command as it is, or, where it is a position, counted as that of its joint is."""
    places = [output for output in found.outputs if output.channel == f"{command.drive.joint}.position"]
    if not places:
        return command
    resting = at_rest(command, places[0], settings)
    if resting is not None or found.found is None:
        return resting or command
    return counted(command, found.found, places[0])


def _add(spec: mujoco.MjSpec, command: Command) -> str:
    """Add the actuator that a command needs; says which."""
    actuator = spec.add_actuator(
        name=command.drive.name, target=command.drive.joint, trntype=mujoco.mjtTrn.mjTRN_JOINT, gear=[1.0] + [0.0] * 5
    )
    given = command.given
    if given is None or given.stiffness == 0.0:
        actuator.set_to_motor()
        return f"Actuator {command.drive.name} was added: the command's force acts at the joint as it is (motor)."
    kp, kv = (float(f"{value:.3g}") for value in (given.stiffness, given.damping))
    actuator.set_to_position(kp=kp, kv=kv)
    return (
        f"Actuator {command.drive.name} was added: a servo towards the command (position) with kp {kp:g} and kv "
        f"{kv:g}, as far as the motion shows them."
    )


def _of_commands(logs: Survey, found: Positions, commands: Sequence[Command], settings: ProposalSettings) -> list[str]:
    """What is unsure about the commands."""
    doubts = [d if d.startswith(c.drive.name) else f"{c.drive.name}: {d}" for c in commands for d in c.doubts]
    given = {command.drive.name for command in commands}
    lacking = [drive.name for drive in found.drives if not drive.added and drive.name not in given]
    if lacking:
        kept = ", ".join(str(each.place) for each in logs.series if each.words.kind in _GIVEN and not each.moves)
        constant = f"{kept} never changes: if that is one" if kept else "If one is constant"
        doubts.append(
            f"No series of the logs is the command of {', '.join(lacking)}: controlled by 0. {constant}, see the "
            "comment at the end of the measurements."
        )
    read = {c.series.place for c in commands} | {part.place for output in found.outputs for part in output.parts}
    unused = [str(each.place) for each in found.commands if each.place not in read]
    if not commands and unused:
        doubts.append(
            f"None of {', '.join(unused)} moves a joint as a command would: the machine is taken to swing freely."
        )
    return [*doubts, *of_units(found.outputs, commands, settings)]


def _beside_model(
    model: mujoco.MjModel, found: Positions, commands: Sequence[Command], settings: ProposalSettings
) -> Iterator[str]:
    """What is unsure of positions and commands beside what the model says of them."""
    yield from lengths_as_angles(model, found.outputs)
    yield from far_slides(model, found, settings)
    yield from cut_off(model, commands)
    yield from _ranges(model, found)


def _ranges(model: mujoco.MjModel, found: Positions) -> list[str]:
    """Joints that move beyond their range in the model."""
    if found.trial is None or found.found is None:
        return []
    moved = beyond(model, found.trial, found.found.readings)
    listed = [
        f"{joint} ({low:.3g} … {high:.3g}, range {model.joint(joint).range[0]:.3g} … {model.joint(joint).range[1]:.3g})"
        for joint, (low, high) in moved.items()
    ]
    if not listed:
        return []
    return [f"Beyond the range in the model, whose stop acts there: {', '.join(listed)}. Check zero, sign and range."]
