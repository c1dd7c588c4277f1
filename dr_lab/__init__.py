"""dr_lab: find why a simulator disagrees with its robot, fix it, and randomise around the rest."""

__version__ = "0.1.0"
