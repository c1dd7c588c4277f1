"""How far the parts of a machine are from each other and from what surrounds it."""

from itertools import combinations

import mujoco
import numpy as np
from mujoco.batch import Batch

from dr_lab.physics.model import Model
from dr_lab.trajectory import Array

_TOGETHER = 256  # configurations at a time
_SAME = 1e-6  # m; MuJoCo's distances of convex shapes are as exact
_ENDLESS = (int(mujoco.mjtGeom.mjGEOM_HFIELD), int(mujoco.mjtGeom.mjGEOM_SDF))  # MuJoCo tells no distance of these


class Clearance:
    """Signed distances between geoms of bodies that may touch, by MuJoCo's distance sensors.

    Geoms that collide count; in a model where none does, its pictures are all that is known of the machine's shape.
    Bodies that are welded together, and those that a joint connects, do not count. What stands fixed in the world
    counts against every part that moves.
    Source: MuJoCo 4.0, XML reference, sensor/distance.

    Args:
        model: the model with its effects.
        z: its context, shape (n,).
        reach: m, beyond which a distance is only known to be larger.
        threads: C threads; None is one.

    Attributes:
        pairs: names of the two geoms of each distance.
    """

    def __init__(self, model: Model, z: Array, reach: float, threads: int | None = 1) -> None:
        spec = model.spec_at(z)
        for geom in spec.geoms:
            geom.name = geom.name or f"geom {geom.id}"
        plain = spec.compile()
        bodies = _able(plain)
        for sensor in list(spec.sensors):
            spec.delete(sensor)
        for first, second in bodies:
            spec.add_sensor(
                type=mujoco.mjtSensor.mjSENS_GEOMDIST,
                objtype=mujoco.mjtObj.mjOBJ_GEOM,
                objname=plain.geom(first).name,
                reftype=mujoco.mjtObj.mjOBJ_GEOM,
                refname=plain.geom(second).name,
                cutoff=reach,
            )
        self.reach = reach
        self.pairs = tuple((plain.geom(first).name, plain.geom(second).name) for first, second in bodies)
        self._batch = Batch(spec.compile(), _TOGETHER, 1 if threads is None else threads) if bodies else None

    def distances(self, qpos: Array) -> Array:
        """Distance of every pair in each configuration, at most `reach`, shape (k, nq) → (k, pairs)."""
        if self._batch is None:
            return np.zeros((len(qpos), 0))
        batch, found = self._batch, np.empty((len(qpos), len(self.pairs)))
        held, sensors = batch.bind("qpos"), batch.bind("sensordata")
        for first in range(0, len(qpos), _TOGETHER):
            part = qpos[first : first + _TOGETHER]
            held[: len(part)] = part
            batch.forward(np.arange(len(part)), stage=mujoco.mjtStage.mjSTAGE_POS.value)
            found[first : first + len(part)] = sensors[: len(part)]
        return found

    def steady(self, low: Array, high: Array, generator: np.random.Generator) -> Array:
        """Pairs as far apart in any pose between two, shape (pairs,), as a wheel from a plate below it."""
        found = self.distances(generator.uniform(low, high, size=(_TOGETHER, len(low))))
        return (np.ptp(found, axis=0) < _SAME) & (found[0] < self.reach - _SAME)


def _able(model: mujoco.MjModel) -> list[tuple[int, int]]:
    """Pairs of geoms that may come closer."""
    solid = ((model.geom_contype != 0) | (model.geom_conaffinity != 0)) & ~np.isin(model.geom_type, _ENDLESS)
    counted = np.flatnonzero(solid if solid.any() else ~np.isin(model.geom_type, _ENDLESS))
    return [(int(a), int(b)) for a, b in combinations(counted, 2) if _apart(model, int(a), int(b))]


def _apart(model: mujoco.MjModel, first: int, second: int) -> bool:
    """Whether two geoms' bodies are neither one nor neighbours."""
    one, other = (int(model.body_weldid[model.geom_bodyid[geom]]) for geom in (first, second))
    parents = [int(model.body_weldid[model.body_parentid[body]]) for body in (one, other)]
    linked = (parents[0] == other and other != 0) or (parents[1] == one and one != 0)
    return one != other and not linked
