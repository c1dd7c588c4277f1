"""A learned force over position and velocity of its joint, and where the log was."""

from dataclasses import dataclass

import numpy as np

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.heat_map import DOUBLE, ColourScale, log_map
from dr_lab.recorders.look import Look
from dr_lab.recorders.training import ContextAxis
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class ForceMap:
    """A learned force in the states near to those of a log.

    Attributes:
        unit: of the force.
        position: of the joint; its values are evenly spaced, shape (n,).
        velocity: likewise, shape (m,).
        force: what else it depends on being as in the nearest state of the log, shape (n, m), NaN where none shows it.
        place: position and velocity of the log's states, shape (k, 2).
    """

    unit: str
    position: ContextAxis
    velocity: ContextAxis
    force: Array
    place: Array

    def places(self, most: int) -> Array:
        """At most so many of the log's states, evenly spread over it, shape (k, 2)."""
        return self.place[:: max(1, -(-len(self.place) // most))]

    def reach(self) -> float:
        """Largest size of the force; 1 where there is none."""
        known = np.abs(self.force[np.isfinite(self.force)])
        return float(known.max()) if len(known) and known.max() > 0.0 else 1.0


def log_force_map(root: Branch, shown: ForceMap, look: Look) -> None:
    """Draw the force, blue where it pushes forwards and orange where it pushes back, with a dot for each state.

    Args:
        root: where to.
        shown: the force.
        look: colours and number of dots.
    """
    reach = shown.reach()
    chart = log_map(root, [shown.position, shown.velocity], shown.force, ColourScale(-reach, reach, DOUBLE), look)
    place = shown.places(look.scatter_points)
    chart.dots("states", place[:, 0], place[:, 1], look.colour("measured"), look.measured_width)
