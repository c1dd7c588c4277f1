"""The plot of an effect's signature; needs matplotlib, which only the documentation does."""

# Sphinx, matplotlib and latex2mathml are in .venv-docs alone.
# pyright: reportMissingImports=false, reportMissingModuleSource=false

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from generator.signature import Signature

# What the force of a family is a function of, as a rule.
AGAINST = {
    "friction": "velocity",
    "transmission": "position",
    "actuator": "command",
    "inertia": "acceleration",
    "environment": "position",
    "sensing": "velocity",
    "open": "position",
}
# Effects whose force, or of sensors residual, is a function of something else.
INSTEAD = {
    "air_drag": "velocity",
    "cogging": "position",
    "encoder_eccentricity": "position",
    "gain_error": "position",
    "sensor_scale": "position",
    "velocity_low_pass": "acceleration",
    "wind": "velocity",
}
BLUE, ORANGE, GREY = "#3b82c4", "#e07b2a", "#808080"  # seen on white and on black
EDGE = 5  # samples at either end, whose differences are one-sided
PEAK = 99.0  # percentile of |force| that the axis holds: an impact would squeeze all else


def draw(shown: Signature, path: Path) -> None:
    """Write the plot as SVG.

    Args:
        shown: an effect at work.
        path: the file.
    """
    style = {"svg.fonttype": "none", "svg.hashsalt": "dr_lab", "font.size": 10, "font.family": "sans-serif"}
    colours = dict.fromkeys(("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color"), GREY)
    with mpl.rc_context({**style, **colours}):
        figure = Figure(figsize=(7.2, 2.6), layout="constrained")
        axes = figure.subplots(1, 1 if shown.force is None else 2, squeeze=False)[0]
        axes[0].plot(shown.time, shown.residual, color=BLUE, lw=1.2)
        axes[0].set(xlabel="time [s]", ylabel=f"residual of {shown.bench.joint} [{shown.bench.unit}]")
        if shown.force is not None:
            _force(axes[1], shown)
        for one in axes:
            one.axhline(0.0, color=GREY, lw=0.5)
            one.spines[["top", "right"]].set_visible(False)
            one.patch.set_alpha(0.0)
        figure.patch.set_alpha(0.0)
        figure.savefig(path, metadata={"Date": None})


def _force(axes: "mpl.axes.Axes", shown: Signature) -> None:
    effect = shown.placed.effect
    argument = INSTEAD.get(effect.name, AGAINST[effect.family])
    # A sensor moves nothing: what it reports wrongly tells more than the force that would move the machine so.
    sensing = effect.family == "sensing"
    values = shown.residual if sensing or shown.force is None else shown.force
    kept = slice(EDGE, -EDGE)
    unit = {
        "position": "rad",
        "velocity": "rad/s",
        "acceleration": "rad/s²",
        "command": shown.bench.command_unit,
    }[argument]
    axes.plot(shown.series[argument][kept], values[kept], color=ORANGE, lw=0.0, marker=".", ms=2.0, rasterized=True)
    most = 1.15 * float(np.percentile(np.abs(values[kept]), PEAK))
    label = f"residual [{shown.bench.unit}]" if sensing else "missing torque [N·m]"
    axes.set(xlabel=f"{argument} [{unit}]", ylabel=label, ylim=(-most, most))
