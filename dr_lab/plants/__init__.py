"""Independent simulators that play the real machine: SciPy on Lagrangian equations, with one hidden effect.

Nothing here knows MuJoCo, the catalogue of effects or the diagnosis, so that what judges the gap never shares code with
what made it.
"""
