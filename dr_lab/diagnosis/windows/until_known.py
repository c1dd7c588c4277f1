"""The first part of windows alone, so that what tells nothing costs no simulation."""

from dataclasses import replace

import numpy as np

from dr_lab.diagnosis.windows.windows import Windows, WindowSamples


def until_known(windows: Windows) -> Windows:
    """The windows up to the last sample that estimates a start; those behind it, which only score, are left out.

    Arrays of samples keep their shapes. Where the fitted samples lie at the end, nothing is left out.

    Args:
        windows: w windows.
    """
    last = max((float(s.time[s.fitted].max()) for s in windows.samples if s.fitted.any()), default=0.0)
    steps = int(np.ceil((last + windows.margin) / windows.step)) + 1
    if steps >= windows.controls.shape[1]:
        return windows
    known = windows.unlogged and windows.unlogged.until(steps)
    samples = tuple(_fitted_alone(s, last) for s in windows.samples)
    return replace(windows, samples=samples, controls=windows.controls[:, :steps], unlogged=known)


def _fitted_alone(samples: WindowSamples, last: float) -> WindowSamples:
    """Without the samples that only score, whose times are drawn to where the simulation still reaches."""
    return replace(samples, time=np.minimum(samples.time, last), scored=np.logical_and(samples.scored, samples.fitted))
