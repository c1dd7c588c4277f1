"""An option as the file has it, which a declared parameter may write over before an effect is written."""

from collections.abc import Sequence

import mujoco
import numpy as np

from dr_lab.trajectory import Array


def note_own(spec: mujoco.MjSpec, label: str, own: Sequence[float]) -> None:
    """Keep the file's own values in a fresh spec until they are asked for.

    Args:
        spec: the caller's own, before any parameter is written.
        label: of the effect, ``effect@site``.
        own: values of the option.
    """
    spec.add_numeric(name=label, size=len(own), data=own)


def noted_own(spec: mujoco.MjSpec, label: str) -> Array:
    """The values that were kept under a label; the spec does not hold them any more."""
    note = spec.numeric(label)
    own = np.array(note.data, dtype=float)
    spec.delete(note)
    return own
