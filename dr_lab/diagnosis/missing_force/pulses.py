"""What a force at a joint does to windows, pulse by pulse: the answer of their samples to any force, to first order."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.evidence.bench import Bench
from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.slopes import differences
from dr_lab.diagnosis.search.free_law import FreeLaw
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.law import Influence, Law, Moment
from dr_lab.physics.model import Model
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class PulseTrain(FreeLaw, ForceLaw):
    """A force at a joint that is constant in each of k parts of a window; in replays alone.

    Attributes:
        part: part to which each step belongs, shape (s,).
    """

    part: NDArray[np.intp]

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The force of each step."""
        heights = np.stack([values[p.name] for p in self.own])
        return _Pulses(int(models[0].joint(site).dofadr[0]), self.part, heights)


def pulse_responses(
    bench: Bench, model: Model, point: Point, pulse: Parameter, joint: str, part: NDArray[np.intp]
) -> Array:
    """Slopes of windows' residuals by the force in each of k parts of them, shape (w, m, k).

    A force F(t) changes the residuals by Σ_k (mean of F in part k) · slope_k / width to first order, so that one batch
    of simulations answers for every force that is tried.

    Args:
        bench: the windows, those that are fitted.
        model: the model.
        point: context and states.
        pulse: name, unit and bounds of a force; slopes are by the width of the bounds.
        joint: at which it acts.
        part: part to which each step belongs, shape (s,).
    """
    own = tuple(replace(pulse, name=f"{pulse.name}_{k}") for k in range(part[-1] + 1))
    pulsed = replace(model, effects=(*model.effects, PulseTrain(pulse.name, joint, own, own, part)))
    space = pulsed.space
    columns = np.array([space.index(p.name) for p in own])
    at = replace(point, z=space.vector(model.space.mapping(point.z)))
    replay = Replay(pulsed, bench.fit, bench.threads)
    return differences(replay, bench.solver, at, states=False, columns=columns)


class _Pulses(Law):
    """The force of each step since the simulations began; heights of shape (k, n)."""

    def __init__(self, dof: int, part: NDArray[np.intp], heights: Array) -> None:
        self.dof, self.part, self.heights, self.step = dof, part, heights, 0

    def act(self, moment: Moment, influence: Influence) -> None:
        influence.force[:, self.dof] += self.heights[self.part[min(self.step, len(self.part) - 1)]]
        self.step += 1

    def replay_history(self, moment: Moment, influence: Influence) -> None:
        """Nothing: pulses begin with the window."""

    def rest(self, rows: NDArray[np.intp]) -> None:
        self.step = 0
