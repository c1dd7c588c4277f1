"""The second engine, where it is installed."""

import importlib.util

import pytest

needs_pinocchio = pytest.mark.skipif(
    importlib.util.find_spec("pinocchio") is None,
    reason="Pinocchio is not installed: pip install 'dr_lab[strangers]' (or pip install pin).",
)
STRANGERS = ("elbow", "elbow_servo", "lift", "paddle", "seven", "seven_servo", "six", "six_servo", "wheel")
