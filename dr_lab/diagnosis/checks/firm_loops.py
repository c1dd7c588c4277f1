"""Closed chains that MuJoCo lets come apart, because nobody said how firm they are."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from dr_lab.diagnosis.checks.numerical_floor import moved
from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.closed_loops import CLOSING, FIRM
from dr_lab.physics.model import Model
from dr_lab.trajectory import Log, MeasurementSet

_DEFAULT = mujoco.MjSpec().add_equality().solref.copy()  # MuJoCo's own: a time constant of 20 ms


@dataclass(frozen=True)
class FirmLoops:
    """The model with its closed chains as firm as the time step allows.

    Attributes:
        model: the model.
        share: by how much that moves an output, in noise standard deviations; 0 where nothing was changed.
        seen: what was seen; empty where nothing was changed.
        solref: what the constraints have instead.
    """

    model: Model
    share: float
    seen: str
    solref: str

    @property
    def message(self) -> str:
        """What was changed and why."""
        return (
            f'{self.seen} All models here are simulated with solref="{self.solref}" in its place. model.xml carries '
            "it: set it in the MJCF, or say there how soft the chains are."
        )


def firm_loops(
    model: Model, logs: Sequence[Log], measured: MeasurementSet, settings: WindowSettings, threads: int | None
) -> FirmLoops:
    """The model whose equality constraints with MuJoCo's default softness have the shortest time constant it allows.

    A constraint whose ``solref`` is given stays: somebody chose it. So does one that draws a body after a mocap body:
    it is a drive. A loop of links opens under load by about its acceleration times the square of the time constant,
    which is 4 mm at 10 m/s² with the default.

    Args:
        model: the model as given.
        logs: logs whose windows are simulated.
        measured: gives the noise.
        settings: how windows are cut.
        threads: C threads.
    """
    spec, names = model.spec.copy(), []
    firm_constant = FIRM * spec.option.timestep
    for k, equality in enumerate(spec.equalities):
        drawn = any((body := spec.body(name)) is not None and body.mocap for name in (equality.name1, equality.name2))
        soft = np.array_equal(equality.solref, _DEFAULT) and firm_constant < _DEFAULT[0]
        if equality.type in CLOSING and soft and not drawn:
            equality.solref = [firm_constant, 1.0]
            names.append(equality.name or f"number {k + 1}")
    if not names:
        return FirmLoops(model, 0.0, "", "")
    firm = replace(model, spec=spec)
    share, worst = moved(model, firm, logs, measured, settings, threads)
    seen = (
        f"The closed chains of equality {', '.join(names)} come apart under load, for MuJoCo's default solref is soft: "
        f"that moves {worst} by {share:.2g} noise standard deviations within a window, which can pass for missing "
        "physics."
    )
    return FirmLoops(firm, share, seen, f"{firm_constant:g} 1")
