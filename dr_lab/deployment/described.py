"""What goes into a policy and what comes out: the entry of its file, and the words for it."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from dr_lab.deployment.inputs import inputs_of
from dr_lab.envs.setting import Setting
from dr_lab.envs.task import Task
from dr_lab.evaluators.evaluator import Subject
from dr_lab.recorders.episode import Episode
from dr_lab.recorders.joint_labels import actuators, columns
from dr_lab.reports.csv_rows import rows_csv
from dr_lab.reports.policy import SCHEMA, InputEntry, OutputEntry, PolicyReport
from dr_lab.reports.quantity import titled
from dr_lab.trajectory import Array

Bounds = tuple[Array, Array]


def described(subject: Subject, trained: Path, bounds: Bounds, episodes: Sequence[Episode], run: Path) -> PolicyReport:
    """What a policy is connected to.

    Args:
        subject: the policy, and what it was trained on.
        trained: folder of the training run.
        bounds: lowest and highest action, shape (a,) each.
        episodes: that it played, at least one.
        run: the run folder.
    """
    setting = subject.setting
    shown = setting.space.parameters if setting.show_context else ()
    inputs = inputs_of(episodes, shown)
    count = len(bounds[0])
    names = actuators(episodes[0].geometry) if _plain(subject) else tuple(f"action_{i}" for i in range(count))
    return PolicyReport(
        schema=SCHEMA,
        verb="export",
        trained=str(trained),
        env=setting.name,
        seconds=setting.seconds,
        inputs=tuple(map(InputEntry, inputs)),
        seen=_said(type(setting.task).observe) if isinstance(setting, Setting) else "",
        outputs=tuple(OutputEntry(*each) for each in zip(names, bounds[0].tolist(), bounds[1].tolist(), strict=True)),
        notes=tuple(_notes(subject, inputs, len(shown))),
        run=str(run),
    )


def course_csv(episode: Episode) -> str:
    """An episode, a row a control step: time, state and observation before it, and the action in it."""
    positions, velocities = ([titled(*column) for column in each] for each in columns(episode.geometry))
    parts = {
        "time [s]": episode.time[:, None],
        **dict(zip(positions, episode.qpos.T[..., None], strict=True)),
        **dict(zip(velocities, episode.qvel.T[..., None], strict=True)),
        **{f"observation_{i}": column[:, None] for i, column in enumerate(episode.observation.T)},
        **{f"action_{i}": column[:, None] for i, column in enumerate(episode.action.T)},
    }
    steps = len(episode.action)
    table = np.hstack([values[:steps] for values in parts.values()])
    return rows_csv([dict(zip(parts, map(repr, row), strict=True)) for row in table.tolist()])


def told(report: PolicyReport) -> str:
    """Inputs, outputs and notes as Markdown."""
    inputs = [f"| {i} | {each.name or 'see below'} |" for i, each in enumerate(report.inputs)]
    outputs = [f"| {i} | {each.name} | {each.low:g} | {each.high:g} |" for i, each in enumerate(report.outputs)]
    notes = [f"* {note}" for note in report.notes]
    head = f"The policy of {report.trained} for {report.env} acts every {1e3 * report.seconds:g} ms."
    tables = [
        "| | observation |",
        "|--:|:--|",
        *inputs,
        "",
        "| | action | lowest | highest |",
        "|--:|:--|--:|--:|",
        *outputs,
    ]
    return "\n".join([head, "", *tables, "", *notes])


def _plain(subject: Subject) -> bool:
    """Whether actions are the actuators' commands."""
    setting = subject.setting
    return isinstance(setting, Setting) and type(setting.task).controls is Task.controls


def _notes(subject: Subject, inputs: Sequence[str | None], shown: int) -> Iterator[str]:
    setting, unknown = subject.setting, [str(i) for i, name in enumerate(inputs) if name is None]
    plays = f"They are those of env={setting.name}: {_said(type(setting))}"
    told = _said(type(setting.task).observe) if isinstance(setting, Setting) else plays
    if unknown:
        yield f"Inputs {', '.join(unknown)} are no single position or velocity. {told}"
    if isinstance(setting, Setting) and not _plain(subject):
        yield f"The task makes commands of the actions. {_said(type(setting.task).controls)}"
    if shown:
        yield f"The last {shown} inputs tell the policy what the machine is like, as shares of the bounds."
    if subject.meta is not None:
        yield "It is the policy that every adaptation begins with, adapted to nothing yet."


def _said(method: object) -> str:
    """The first sentence of a method's docstring."""
    return (method.__doc__ or "").strip().partition("\n")[0]
