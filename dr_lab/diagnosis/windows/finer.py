"""Windows for the same model at a finer time step."""

from dataclasses import replace

import numpy as np

from dr_lab.diagnosis.windows.windows import Windows


def finer(windows: Windows, parts: int) -> Windows:
    """The same windows at a step of which `parts` make one; over these, commands and the motion before are held.

    Every part of a step sees what the whole step saw, so that only the integration differs; a delay that interpolates
    between steps reads a command or a reading up to half a step later.
    """
    before, missing = windows.before, windows.unlogged
    held = {name: np.repeat(getattr(before, name), parts, axis=1) for name in ("qpos", "qvel", "controls")}
    return replace(
        windows,
        controls=np.repeat(windows.controls, parts, axis=1),
        past=np.repeat(windows.past, parts, axis=1),
        before=replace(before, **held),
        unlogged=missing and replace(missing, size=np.repeat(missing.size, parts, axis=2)),
        step=windows.step / parts,
    )
