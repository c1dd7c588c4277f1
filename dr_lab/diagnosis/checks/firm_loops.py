"""Closed chains that MuJoCo lets come apart, because nobody said how firm they are."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from dr_lab.diagnosis.checks.model_check import ModelCheckSettings
from dr_lab.diagnosis.checks.numerical_floor import moved
from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.closed_loops import CLOSING, FIRM
from dr_lab.physics.model import Model
from dr_lab.trajectory import Log, MeasurementSet

_SOLREF = mujoco.MjSpec().add_equality().solref.copy()  # MuJoCo's own: a time constant of 20 ms
_SOLIMP = mujoco.MjSpec().add_equality().solimp.copy()  # and impedances of 0.9 to 0.95


@dataclass(frozen=True)
class FirmLoops:
    """The model with its closed chains as firm as the time step allows.

    Attributes:
        model: the model.
        share: by how much that moves an output, in noise standard deviations; 0 where nothing was changed.
        seen: what was seen; empty where nothing was changed.
        asked: what the constraints have instead, as an MJCF says it.
    """

    model: Model
    share: float
    seen: str
    asked: str

    @property
    def message(self) -> str:
        """What was changed and why."""
        return (
            f"{self.seen} All models here are simulated with {self.asked} in its place. The model.xml of a run "
            "has that; your own MJCF has not: set it there, too, or say there how soft the chains are."
        )


def firm_loops(
    model: Model,
    logs: Sequence[Log],
    measured: MeasurementSet,
    settings: WindowSettings,
    check: ModelCheckSettings,
    threads: int | None,
) -> FirmLoops:
    """The model whose equality constraints with MuJoCo's default softness are as firm as it allows.

    They get the shortest time constant T, and the impedance d of `check` unless another than the default is given. A
    constraint whose ``solref`` is given stays: somebody chose it. So does one that draws a body after a mocap body: it
    is a drive. A loop of links opens under load by about a T² (1 − d)/d, where a is the acceleration at which its ends
    would part without the constraint.

    Source: MuJoCo 4.0, modeling chapter ("Solver parameters").

    Args:
        model: the model as given.
        logs: logs whose windows are simulated.
        measured: gives the noise.
        settings: how windows are cut.
        check: how firm closed chains are.
        threads: C threads.
    """
    spec, names, harder = model.spec.copy(), [], False
    firm_constant = FIRM * spec.option.timestep
    for k, equality in enumerate(spec.equalities):
        drawn = any((body := spec.body(name)) is not None and body.mocap for name in (equality.name1, equality.name2))
        soft = np.array_equal(equality.solref, _SOLREF) and firm_constant < _SOLREF[0]
        if equality.type in CLOSING and soft and not drawn:
            equality.solref = [firm_constant, 1.0]
            if np.array_equal(equality.solimp, _SOLIMP):
                equality.solimp[:2], harder = check.chain_impedance, True
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
    impedance = f' solimp="{check.chain_impedance:g} {check.chain_impedance:g}"' if harder else ""
    return FirmLoops(firm, share, seen, f'solref="{firm_constant:g} 1"{impedance}')
