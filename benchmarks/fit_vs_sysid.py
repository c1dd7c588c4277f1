"""Is a fit as fast as MuJoCo's own `mujoco.sysid`, and does it end at the same minimum?

A pendulum with a motor, its damping and dry friction unknown, two logs of 6 s at 500 Hz of noisy position and velocity.
Both tools get the same model, data, bounds and start, and all cores; `mujoco.sysid` runs with its own optimiser and
with SciPy's, at their defaults. It is told the true initial state and simulates each log as a whole; dr_lab is not told
and fits the start of every window (settings of `dr-lab fit`, windows over all of the data). Timed is what follows the
data in memory: windows cut or sequences built, and the fit. Runs alternate; times are medians, the ratio is that of
dr_lab to the faster optimiser.

The minimum is the same if each parameter differs by less than 1 % of its true value and lies within 2 % of it (dr_lab's
standard deviations are 0.4 and 0.5 %: start states that are fitted take some of the information).

    pip install -e '.[bench]'
    python benchmarks/fit_vs_sysid.py --repeats 7
"""

import argparse
import contextlib
import io
import json
import os
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import mujoco
import numpy as np
from hydra.utils import instantiate
from mujoco import sysid
from rich.console import Console
from rich.table import Table

from dr_lab.cli.compose import compose
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.windows.windows import cut
from dr_lab.physics.model import Model, from_spec
from dr_lab.trajectory import Array, Log, MeasurementSet, Noise, Signal

STEP, SECONDS = 0.002, 6.0  # s
CHANNELS = {"position": ("rad", 2e-3), "velocity": ("rad/s", 2e-2)}  # unit, noise
TRUTH, START = np.array([0.05, 0.15]), np.array([0.2, 0.05])  # damping in N·m·s/rad, dry friction in N·m
AGREE, NEAR = 0.01, 0.02  # shares of the truth
PENDULUM = f"""<mujoco model="pendulum">
  <compiler angle="radian"/> <option timestep="{STEP}"/>
  <worldbody><body>
    <inertial mass="1" pos="0 0 -0.3" diaginertia="0.01 0.01 0.001"/>
    <joint name="hinge" axis="0 1 0" damping="{START[0]}" frictionloss="{START[1]}"/>
  </body></worldbody>
  <actuator><motor name="drive" joint="hinge"/></actuator>
  <sensor> <jointpos joint="hinge"/> <jointvel joint="hinge"/> </sensor>
</mujoco>"""
FREE = {
    "damping": {"target": "joint.hinge.damping", "unit": "N·m·s/rad", "low": 0.0, "high": 0.5},
    "friction": {"target": "joint.hinge.frictionloss", "unit": "N·m", "low": 0.0, "high": 0.6},
}
CLOCK: Array = STEP * np.arange(round(SECONDS / STEP), dtype=np.float64)


def command(seed: int) -> Array:
    """Multi-sine torque of every step, N·m."""
    phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, 4)
    return np.sin(2 * np.pi * np.outer(CLOCK, (0.4, 0.9, 1.7, 2.9)) + phases).sum(1)


def measured(model: Model, seed: int) -> Log:
    """A noisy log of the true machine, from rest."""
    compiled, rng = model.compile(TRUTH), np.random.default_rng(100 + seed)
    data, torques, motion = mujoco.MjData(compiled), command(seed), np.empty((2, len(CLOCK)))
    for k, torque in enumerate(torques):
        motion[:, k] = data.qpos[0], data.qvel[0]
        data.ctrl[0] = torque
        mujoco.mj_step(compiled, data)
    outputs = {
        f"hinge.{name}": Signal(f"hinge.{name}", unit, CLOCK, true + std * rng.normal(size=len(CLOCK)))
        for (name, (unit, std)), true in zip(CHANNELS.items(), motion, strict=True)
    }
    return Log(f"log_{seed}", outputs, {"drive": Signal("drive", "N·m", CLOCK, torques)})


def with_dr_lab(model: Model, data: MeasurementSet, settings: Any) -> Array:  # noqa: ANN401 (Hydra's configuration)
    """Damping and friction by dr_lab's `Fitter`."""
    windows = instantiate(settings.windows)
    windows = replace(windows, seconds=SECONDS * len(data.fit))
    replay = Replay(model, cut(data.fit, data, model.nominal(), windows))
    return Fitter(replay, instantiate(settings.solver)).run(model.space.nominal).z


def with_sysid(model: Model, data: MeasurementSet, optimizer: str) -> Array:
    """The same by `mujoco.sysid`; what it prints is not shown."""
    parameters, compiled = sysid.ParameterDict(), model.nominal()
    for p in model.declared:
        write = model.targets[p.name].write
        modifier = lambda spec, parameter, write=write: write(spec, float(parameter.value[0]))  # noqa: E731
        parameters.add(sysid.Parameter(p.name, p.nominal, p.low, p.high, modifier=modifier))
    signals = [("hinge_qpos", sysid.SignalType.MjStateQPos), ("hinge_qvel", sysid.SignalType.MjStateQVel)]
    values = [np.column_stack([s.value for s in log.outputs.values()]) for log in data.fit]
    sequences = sysid.ModelSequences(
        model.name,
        model.spec,
        [log.name for log in data.fit],
        [sysid.create_initial_state(compiled, np.zeros(1), np.zeros(1))] * len(values),
        [sysid.TimeSeries(CLOCK, log.commands["drive"].value[:, None]) for log in data.fit],
        [sysid.TimeSeries.from_names(CLOCK, value, compiled, signals) for value in values],
    )
    residual = sysid.build_residual_fn(models_sequences=[sequences])
    with contextlib.redirect_stdout(io.StringIO()):
        _, result = sysid.optimize(parameters, residual, optimizer=optimizer, verbose=False)
    return result.x.ravel()


def timed(fit: Callable[[], Array]) -> Array:
    """Wall and CPU seconds, then the parameters."""
    wall, cpu = time.perf_counter(), time.process_time()
    z = fit()
    return np.array([time.perf_counter() - wall, time.process_time() - cpu, *z])


def main() -> None:
    """Fit in turn and print the table and, last, one JSON line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=7)
    options = parser.parse_args()
    if not hasattr(sysid, "optimize"):  # it imports without its libraries, but empty
        print("mujoco.sysid lacks its libraries, nothing was compared. Install them: pip install -e '.[bench]'")
        print(json.dumps({"skipped": "mujoco.sysid is not installed"}))
        return
    model = from_spec("pendulum", mujoco.MjSpec.from_string(PENDULUM), FREE)
    noise = {f"hinge.{name}": Noise(std, unit, "given") for name, (unit, std) in CHANNELS.items()}
    data = MeasurementSet("pendulum", (measured(model, 0), measured(model, 1)), (), noise, dict.fromkeys(noise, 0.1))
    fits = {"dr_lab": partial(with_dr_lab, model, data, compose("fit"))}
    fits |= {f"mujoco.sysid, {name}": partial(with_sysid, model, data, name) for name in ("mujoco", "scipy")}
    load, runs = os.getloadavg()[0], [[timed(fit) for fit in fits.values()] for _ in range(options.repeats)]
    medians = {name: np.median([run[k] for run in runs], axis=0) for k, name in enumerate(fits)}
    table = Table("fit", "wall s", "CPU s", "damping", "friction")
    for name, (wall, cpu, *z) in medians.items():
        table.add_row(name, f"{wall:.3f}", f"{cpu:.3f}", f"{z[0]:.5f}", f"{z[1]:.5f}")
    Console(width=120).print(table)
    ours, *theirs = medians.values()
    apart = max(float(np.abs((other - ours)[2:] / TRUTH).max()) for other in theirs)
    far = max(float(np.abs(each[2:] / TRUTH - 1).max()) for each in medians.values())
    ratio_wall, ratio_cpu = ours[:2] / np.min([other[:2] for other in theirs], axis=0)
    summary = {
        "wall_s": {name: m[0] for name, m in medians.items()},
        "cpu_s": {name: m[1] for name, m in medians.items()},
        "ratio_wall": ratio_wall,
        "ratio_cpu": ratio_cpu,
        "apart": apart,
        "from_truth": far,
        "same_minimum": apart < AGREE and far < NEAR,
        "load_before": load,
    }
    print(json.dumps(summary))


if __name__ == "__main__":
    main()
