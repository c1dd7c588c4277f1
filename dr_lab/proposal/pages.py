"""The files of a proposal: MJCF, measurements and model; comments say what was found and what is unsure."""

import json
import math
import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence

import mujoco

from dr_lab.physics.mjcf import mjcf
from dr_lab.physics.model import from_spec
from dr_lab.proposal.counts import entry_of_counts, may_be_counts, other_scales
from dr_lab.proposal.drives import Command
from dr_lab.proposal.freedom import Entry
from dr_lab.proposal.output import Output
from dr_lab.proposal.propose import Proposal
from dr_lab.proposal.split import Split

_WIDTH = 116
_ANGLES = {"rad": 1.0, "deg": math.pi / 180}  # rad
_PLAIN = re.compile(r"[A-Za-z_/][\w./·^°-]*")
_WORDS = {"true", "false", "null", "yes", "no", "on", "off", "none", "y", "n"}

CHANNEL_KEYS = """\
# What a channel may hold beside its place (topic and field, or column) and unit; value = unit · (sign · scale · number
# + offset), and all keys may be left out:
#   sign: -1          turns the direction
#   scale: 0.01       factor into the unit: a gear ratio, an amplifier's gain
#   offset: -1.57     in the unit: where the zero of the log differs from the model's
#   wrap: true        an angle that jumps by full turns; behind a gear in scale give the jump in the unit: wrap: 0.628
#   latency: 0.002    s by which the stamps lie after the true times
#   clock: header     whose stamps: header, publish or log of a message, column of a table
#   noise_std: 0.001  of the numbers, in the unit; estimated where it is left out
#   between: line     of a command: hold its value until the next sample, go in a straight line to it, or unknown, if it
#                     changes without being logged: what it did is then estimated; left out, it holds as far as it can
# A field or column may be a sum: {shoulder: 1, elbow: -1}. A command that is the same all the time is a sum without
# weight: {column: {ANY: 0}, offset: 0.5, unit: rad}, or with topic and field.
# Thresholds of the data contract that this machine needs otherwise stand in a line of their own, such as
# contract: {speed_limit: 400}, in rad/s; --cfg job -p measurements.contract behind a verb lists them.
"""

_PARAMETERS = (
    "# A parameter is a number of the MJCF that is fitted, between two bounds: body.<name>.mass, .inertia_scale,",
    "# .ipos[0]; joint.<name>.damping, .armature, .frictionloss, .stiffness; actuator.<name>.gear[0], .force_limit;",
    "# of a position servo also .kp and .kv; …",
    "# .mass scales the body's inertia with it, as a density does; .inertia_scale is a factor on the inertia alone.",
    "# Dry friction, backlash, delays and so on need none: they are effects, which dr-lab close tries and adds.",
)


def measurements_page(proposal: Proposal, split: Split) -> str:
    """``measurements/<name>.yaml``."""
    clock = proposal.logs.clock
    lines = [f"# logs of {proposal.robot.name}, as dr-lab init read them", "#"]
    lines += _comments("Unsure: ", proposal.doubts) or ["# Nothing is unsure."]
    lines += ["defaults:", "  - /data_contract@contract: default", "  - _self_"]
    lines += ["_target_: dr_lab.measurements.read.read", f"name: {proposal.robot.name}"]
    lines += ["logs:", *(f"  - {_text(str(path))}" for path in split.files)]
    if clock is not None and clock.group:
        lines.append(f"group: {_text(clock.group)}  # every value of this column is a log, FILE/VALUE")
    if split.fit is not None:
        lines.append(_names("fit", split.fit))
    lines.append(_names("held_out", split.held_out) + f"  # never fitted; what models are judged by{_said(split)}")
    if clock is not None:
        lines.append(f"time: {{column: {_text(clock.axis.column)}, unit: {clock.axis.unit}}}")
    else:
        lines.append(f"clock: {_clock(proposal)}  # of the channels that name none")
    lines.append("outputs:  # <joint>.position, <joint>.velocity, sensor.<name> or of one axis sensor.<name>.x")
    lines += [_channel(each.channel, _of_output(each, proposal), each.why) for each in proposal.outputs]
    lines += _counts_of_outputs(proposal)
    lines.append("commands:  # by actuator" if proposal.commands else "commands: {}  # none: the machine swings freely")
    lines += [_channel(each.drive.name, _of_command(each, proposal), each.why) for each in proposal.commands]
    lines += _counts_of_commands(proposal)
    lines += _comments("Not read: ", [", ".join(proposal.unread)] if proposal.unread else [])
    return "\n".join([*lines, *_left_out(split), CHANNEL_KEYS])


def model_page(proposal: Proposal) -> str:
    """``model/<name>.yaml``."""
    name = proposal.robot.name
    lines = [f"# {name}, from {proposal.robot.path.name}: what of its physics may be wrong", "#"]
    lines += _comments("", proposal.notes)
    lines += [
        *_PARAMETERS,
        "_target_: dr_lab.physics.model.load",
        f"name: {name}",
        f"mjcf: ${{conf:model/{name}.xml}}",
        "parameters:",
    ]
    lines += [f"  {_text(key)}: {_parameter(entry)}" for key, entry in proposal.parameters.items()]
    return "\n".join([*lines, ""])


def model_xml(proposal: Proposal) -> str:
    """``model/<name>.xml``: the file as it was where nothing was changed and nothing beside it is needed."""
    if not proposal.changed:
        text = proposal.robot.path.read_text(encoding="utf-8")
        unnamed = mujoco.MjSpec.from_string(text) if "<include" not in text and "file=" not in text else None
        if unnamed is not None and all(e.name for kind in (unnamed.joints, unnamed.actuators) for e in kind):
            return text
    model = from_spec(proposal.robot.name, proposal.spec, {})
    return mjcf(model, model.space.nominal)


def _parameter(entry: Entry) -> str:
    if isinstance(entry, Mapping):
        return _flow(entry)
    return f"[{', '.join(map(_text, entry))}]  # all ten inertial parameters of each"


def _comments(prefix: str, sentences: Sequence[str]) -> list[str]:
    return [
        line
        for sentence in sentences
        for line in textwrap.wrap(prefix + sentence, _WIDTH, initial_indent="# ", subsequent_indent="#   ")
    ]


def _left_out(split: Split) -> Iterator[str]:
    for name, why in {**split.left_out, **split.shortened}.items():
        yield from textwrap.wrap(f"Left out: {name}. {why}", _WIDTH, initial_indent="# ", subsequent_indent="#   ")


def _said(split: Split) -> str:
    return f",{split.said_of_reach}" if split.said_of_reach else ""


def _names(key: str, names: Sequence[str]) -> str:
    return f"{key}: [{', '.join(map(_text, names))}]"


def _channel(name: str, entry: Mapping[str, object], why: str) -> str:
    return f"  {_text(name)}: {_flow(entry)}  # {why}"


def _counts_of_outputs(proposal: Proposal) -> Iterator[str]:
    """What to write for angles that may be counts."""
    may = [each for each in proposal.outputs if each.counts]
    if may:
        yield f"  # If the numbers are counts, {may[0].counts[0]} a turn, write in place of these lines"
        yield f"  # (scale is {other_scales(may[0].counts)} a turn):"
    for each in may:
        yield f"  # {_text(each.channel)}: {_flow(entry_of_counts(_of_output(each, proposal), each.counts))}"


def _counts_of_commands(proposal: Proposal) -> Iterator[str]:
    """What to write for commands of such angles: those asked for in the same counts, forces in no unit that is said."""
    counted = {each.channel.rpartition(".")[0]: each for each in proposal.outputs if each.counts}
    entries = {
        each.drive.name: entry
        for each in proposal.commands
        if each.drive.joint in counted and (entry := _in_counts(each, counted[each.drive.joint], proposal))
    }
    if entries:
        yield "  # If the numbers are counts, as those of the outputs, write in place of these lines:"
    for name, entry in entries.items():
        yield f"  # {_text(name)}: {_flow(entry)}"


def _in_counts(command: Command, angle: Output, proposal: Proposal) -> Mapping[str, object] | None:
    """A command's entry if its joint's angle is in counts; None where that is the same, or not known.

    A force is as much smaller as a count is than what the angle's numbers were read as.
    """
    entry = _of_command(command, proposal)
    if command.unit in _ANGLES:
        return entry_of_counts(entry, angle.counts) if may_be_counts(command.series) else None
    if command.drive.servo or command.given is None or command.series.words.unit or angle.unit not in _ANGLES:
        return None
    smaller = 2 * math.pi / angle.counts[0] / (_ANGLES[angle.unit] * angle.scale)
    return {**entry, "scale": float(f"{abs(command.given.gain / command.drive.force) * smaller:.2g}")}


def _of_output(output: Output, proposal: Proposal) -> dict[str, object]:
    entry = {**output.entry, "unit": output.unit}
    if output.sign < 0:
        entry["sign"] = -1
    if output.scale != 1.0:
        entry["scale"] = output.scale
    if output.offset:
        entry["offset"] = float(f"{output.offset:.15g}")
    if output.wrap:
        entry["wrap"] = True
    return entry | _own_clock(output.parts[0].place.clock, proposal)


def _of_command(command: Command, proposal: Proposal) -> dict[str, object]:
    entry: dict[str, object] = {**command.series.place.entry, "unit": command.unit}
    if command.sign < 0:
        entry["sign"] = -1
    if command.scale != 1.0:
        entry["scale"] = command.scale
    if command.offset:
        entry["offset"] = float(f"{command.offset:.15g}")
    return entry | _own_clock(command.series.place.clock, proposal)


def _own_clock(clock: str, proposal: Proposal) -> dict[str, object]:
    return {} if proposal.logs.clock is not None or clock == _clock(proposal) else {"clock": clock}


def _clock(proposal: Proposal) -> str:
    """That of the outputs."""
    return proposal.outputs[0].parts[0].place.clock


def _flow(entry: Mapping[str, object]) -> str:
    return "{" + ", ".join(f"{key}: {_value(value)}" for key, value in entry.items()) + "}"


def _value(value: object) -> str:
    return _text(value) if isinstance(value, str) else json.dumps(value)


def _text(text: str) -> str:
    """A yaml text, quoted where it would not be one."""
    plain = _PLAIN.fullmatch(text) and text.lower() not in _WORDS
    return text if plain else json.dumps(text, ensure_ascii=False)
