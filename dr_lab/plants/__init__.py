"""Simulators that play the real machine: SciPy integrates its equations of motion, with one or two hidden effects.

Nothing here knows the catalogue of effects or the diagnosis, so that what judges the gap never shares code with what
made it. The machines whose equations are not written out here take them from MuJoCo, at one instant at a time.
"""
