"""A cable between a point of the world and a body."""

from dataclasses import dataclass

import numpy as np

from dr_lab.trajectory import Array


@dataclass(frozen=True, eq=False)
class Cable:
    """An elastic cable that pulls a body's centre of mass towards its anchor where it is stretched.

    Attributes:
        body: name of the body.
        anchor: where it is fixed, m, shape (3,).
        length: where it is slack, m.
        stiffness: N/m.
    """

    body: str
    anchor: Array
    length: float
    stiffness: float

    def pull(self, place: Array) -> Array:
        """Force on the body's centre at a place, N, shape (3,)."""
        way = self.anchor - place
        far = float(np.linalg.norm(way))
        return self.stiffness * max(0.0, 1.0 - self.length / far) * way if far else np.zeros(3)
