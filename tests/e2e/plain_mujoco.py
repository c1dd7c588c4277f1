"""Repeat a run's recorded rollout with MuJoCo alone: no line of dr_lab takes part.

    python plain_mujoco.py RUN_FOLDER …

Prints a JSON object: by folder, the largest difference of positions and of velocities from the recorded ones.
"""

import json
import sys
from pathlib import Path

import mujoco
import numpy as np

STATE = mujoco.mjtState.mjSTATE_INTEGRATION


def differences(folder: Path) -> list[float]:
    """Largest |Δqpos| and |Δqvel| over all windows of a run."""
    model = mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
    data = mujoco.MjData(model)
    with np.load(folder / "rollout.npz") as stored:
        recorded = {name: stored[name] for name in ("state", "ctrl", "qpos", "qvel")}
    worst = [0.0, 0.0]
    for state, ctrl, qpos, qvel in zip(*recorded.values(), strict=True):
        mujoco.mj_setState(model, data, state, STATE)
        motion = [(data.qpos.copy(), data.qvel.copy())]
        for control in ctrl:
            data.ctrl[:] = control
            mujoco.mj_step(model, data)
            motion.append((data.qpos.copy(), data.qvel.copy()))
        for part, (played, told) in enumerate(zip(zip(*motion, strict=True), (qpos, qvel), strict=True)):
            worst[part] = max(worst[part], float(np.abs(np.array(played) - told).max()))
    return worst


if __name__ == "__main__":
    found = {name: differences(Path(name)) for name in sys.argv[1:]}
    if any(name.partition(".")[0] == "dr_lab" for name in sys.modules):
        sys.exit("dr_lab was imported")
    print(json.dumps(found))
