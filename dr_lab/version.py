"""The version of dr_lab."""

__version__ = "0.1.0"
