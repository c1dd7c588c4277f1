"""A force that was learned from logs, and the file that a run keeps it in."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from dr_lab.errors import ConfigError
from dr_lab.files import write_text
from dr_lab.physics.radial_basis import Input, RadialBasis, Seen, features
from dr_lab.trajectory import Array

FILE = "residual_force.json"
SCHEMA = "dr_lab/residual_force/1"
_LAW = (
    "force = gate * sum_k coefficients[k] * exp(-|x - centres[k]|^2 / 2); x holds, input by input, value / scale, of "
    "an angle cos(value) / scale and sin(value) / scale; gate is 1 within near of a centre, 0 beyond far, and "
    "1 - 3 s^2 + 2 s^3 between, s = (distance - near) / (far - near); an odd force has exp(-|x - c|^2 / 2) - "
    "exp(-|x' - c|^2 / 2) instead, x' being x with all but cosines negated, and the lesser distance of the two"
)


@dataclass(frozen=True)
class LearnedForce:
    """A generalised force of state and command.

    F(x) = Σ_k c_k g(x) exp(−|x − c_k|² / 2), 0 away from what was seen; see `RadialBasis`.

    Attributes:
        basis: the bell curves.
        coefficients: their sizes, N·m or N, shape (m,).
        unit: of the force.
    """

    basis: RadialBasis
    coefficients: Array
    unit: str

    def at(self, points: Array) -> Array:
        """The force at points (n, d) as `features` gives them, shape (n,)."""
        return self.basis.bells(points) @ self.coefficients

    def of(self, model: mujoco.MjModel, seen: Seen) -> Array:
        """The force in n states of a model, shape (n,).

        Raises:
            ModelError: the model lacks a joint or an actuator that the force depends on.
        """
        return self.at(features(self.basis.inputs, model, seen))


def write_learned_forces(folder: Path, forces: Mapping[str, LearnedForce]) -> None:
    """Write learned forces by joint into a run folder, whole or not at all."""
    content = {"schema": SCHEMA, "law": _LAW, "forces": {joint: _plain(force) for joint, force in forces.items()}}
    write_text(folder / FILE, json.dumps(content, indent=1, ensure_ascii=False) + "\n")


def read_learned_forces(run: str | Path) -> dict[str, LearnedForce]:
    """The learned forces of a run by joint; none where it learned nothing.

    Args:
        run: the run folder, or its `context.yaml`.

    Raises:
        ConfigError: the file is not that of learned forces.
    """
    given = Path(run).expanduser()
    path = (given if given.is_dir() else given.parent) / FILE
    if not path.is_file():
        return {}
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        found = {joint: _force(each) for joint, each in content["forces"].items() if content["schema"] == SCHEMA}
    except (KeyError, TypeError, ValueError):
        found = {}
    if not found:
        raise ConfigError(f"{path} holds no learned forces: expected schema {SCHEMA}. Make the run again.")
    return found


def _plain(force: LearnedForce) -> dict[str, object]:
    basis = force.basis
    return {
        "unit": force.unit,
        "inputs": [asdict(each) for each in basis.inputs],
        "odd": basis.odd,
        "near": basis.near,
        "far": basis.far,
        "centres": basis.centres.tolist(),
        "coefficients": force.coefficients.tolist(),
    }


def _force(content: Mapping[str, Any]) -> LearnedForce:
    inputs = tuple(Input(**each) for each in content["inputs"])
    centres, near, far = np.array(content["centres"], dtype=float), float(content["near"]), float(content["far"])
    basis = RadialBasis(inputs, centres, near, far, bool(content["odd"]))
    return LearnedForce(basis, np.array(content["coefficients"], dtype=float), str(content["unit"]))
