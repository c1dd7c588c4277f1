"""The true motion of a plant under proposed commands, beside limits that are taken from its true motion in the logs."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import mujoco
import numpy as np

from dr_lab.comparison.study import Study
from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.next_experiment.settings import ExperimentSettings
from dr_lab.plants.command import Command
from dr_lab.plants.motion import simulate
from dr_lab.plants.rig import Rig
from dr_lab.trajectory import Array, Signal

FINE = 0.0005  # s between two looks at the true motion
PARTS = 0.005  # s between two looks at the distances of parts
HAIR = 1.0 + 1e-6  # times a limit; rounding


@dataclass(frozen=True)
class Limits:
    """What the true motion must keep: positions, speeds, forces, distances of geoms that may not come closer."""

    low: Array
    high: Array
    speed: Array
    force: Array
    apart: Mapping[tuple[int, int], float]


@dataclass(frozen=True)
class Bed:
    """One machine with its plant, its logs and two fitted rivals."""

    name: str
    rig: Rig
    seed: int
    study: Study
    rivals: tuple[FittedModel, FittedModel]
    settings: ExperimentSettings

    @cached_property
    def true(self) -> Any:  # noqa: ANN401 (one of the plants' machines)
        """The machine as it is."""
        return self.rig.nominal.machine(self.rig.nominal.true_values(self.seed))

    @cached_property
    def model(self) -> mujoco.MjModel:
        """Shapes, and actuators as documented, of the model as given."""
        return self.study.comparison.model.nominal()

    @cached_property
    def limits(self) -> Limits:
        """Those that the true motion of the logs gives."""
        motions = [self._logged(number) for number in range(len(self.rig.peaks))]
        qpos, qvel, force = (np.concatenate([each[i] for each in motions]) for i in range(3))
        margin, clearance = self.settings.safety.margin, self.settings.safety.clearance
        low, high = qpos.min(axis=0), qpos.max(axis=0)
        low, high = low - margin * (high - low), high + margin * (high - low)
        for joint in np.flatnonzero(self.model.jnt_limited):
            low[joint], high[joint] = self.model.jnt_range[joint]
        most = (1 + margin) * np.abs(force).max(axis=0)
        limited = self.model.actuator_forcelimited.astype(bool)
        most[limited] = np.abs(self.model.actuator_forcerange[limited]).max(axis=1)
        closest = self.closest(qpos[:: round(PARTS / FINE)], 4 * clearance)
        apart = {pair: min(clearance, 0.9 * distance) for pair, distance in closest.items() if distance > 0}
        return Limits(low, high, (1 + margin) * np.abs(qvel).max(axis=0), most, apart)

    def _logged(self, number: int) -> tuple[Array, Array, Array]:
        issued, wish = self.rig.asked(self.seed, number)
        times = np.arange(0.0, self.rig.duration, FINE)
        states, command = self.rig.moved(self.true, issued, times, wish)
        return self._parts(states, times, issued, command)

    def played(self, commands: Mapping[str, Signal], start: Array) -> tuple[Array, Array, Array]:
        """True positions, velocities and actuator forces under held commands from rest."""
        rows = [commands[name] for name in self.rig.actuators]
        sent, values = rows[0].time, np.stack([row.value for row in rows], axis=1)
        times = np.arange(0.0, float(sent[-1]), FINE)
        states = simulate(
            self.true,
            self.rig.hidden,
            [Command(sent, column, float(column[0])) for column in values.T],
            times,
            accuracy=self.rig.accuracy,
            start=(*start.tolist(), *np.zeros(len(start)).tolist()),
        )
        return self._parts(states, times, sent, values)

    def _parts(self, states: Array, times: Array, sent: Array, values: Array) -> tuple[Array, Array, Array]:
        count = len(self.rig.joints)
        qpos, qvel = states[:, :count], states[:, count : 2 * count]
        held = np.clip(np.searchsorted(sent, times, side="right") - 1, 0, None)
        force = np.zeros((len(times), self.model.nactuator))
        data = mujoco.MjData(self.model)
        for k in range(0, len(times), 4):
            data.qpos[:], data.qvel[:], data.ctrl[:] = qpos[k], qvel[k], values[held[k]]
            mujoco.mj_fwdPosition(self.model, data)
            mujoco.mj_fwdVelocity(self.model, data)
            mujoco.mj_fwdActuation(self.model, data)
            force[k : k + 4] = data.actuator_force
        return qpos, qvel, force

    def closest(self, qpos: Array, reach: float) -> dict[tuple[int, int], float]:
        """Smallest distance of every two geoms of bodies that are no neighbours, m."""
        model, data = self.model, mujoco.MjData(self.model)
        solid = ((model.geom_contype != 0) | (model.geom_conaffinity != 0)).any()
        geoms = [g for g in range(model.ngeom) if not solid or model.geom_contype[g] or model.geom_conaffinity[g]]
        weld = model.body_weldid[model.geom_bodyid]
        parent = model.body_weldid[model.body_parentid]
        pairs = [
            (a, b)
            for a, b in combinations(geoms, 2)
            if weld[a] != weld[b]
            and not (weld[a] and parent[weld[b]] == weld[a])
            and not (weld[b] and parent[weld[a]] == weld[b])
        ]
        found = dict.fromkeys(pairs, reach)
        for row in qpos:
            data.qpos[:] = row
            mujoco.mj_kinematics(model, data)
            for pair in pairs:
                found[pair] = min(found[pair], mujoco.mj_geomDistance(model, data, *pair, reach, None))
        return found

    def violations(self, commands: Mapping[str, Signal], start: Array) -> tuple[list[str], float]:
        """What limits the true motion leaves, in words, and the largest share that it takes of any."""
        qpos, qvel, force = self.played(commands, start)
        limits, shares = self.limits, {}
        for j, joint in enumerate(self.rig.joints):
            middle, half = (limits.high[j] + limits.low[j]) / 2, (limits.high[j] - limits.low[j]) / 2
            shares[f"range of {joint}"] = float(np.abs(qpos[:, j] - middle).max() / half)
            shares[f"speed of {joint}"] = float(np.abs(qvel[:, j]).max() / limits.speed[j])
        for a, actuator in enumerate(self.rig.actuators):
            shares[f"force of {actuator}"] = float(np.abs(force[:, a]).max() / limits.force[a])
        closest = self.closest(qpos[:: round(PARTS / FINE)], 2 * self.settings.safety.clearance)
        close = [f"distance of {pair}" for pair, least in limits.apart.items() if closest[pair] * HAIR < least]
        return [name for name, share in shares.items() if share > HAIR] + close, max(shares.values())
