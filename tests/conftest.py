"""Fixtures that several folders of tests share."""

import os

# Tests run side by side, and small matrices gain nothing from a second thread: with two in each of two workers some
# take ten times as long. Torch and BLAS read it when they are loaded, so it stands before the other imports.
os.environ.setdefault("OMP_NUM_THREADS", "1")

from cheaper import compose_once, keep_what_is_loaded, look_for_cycles_rarely, parse_once
from recorder_samples import close_report, compare_report, furuta, look, overlay

__all__ = ["close_report", "compare_report", "furuta", "look", "overlay"]

look_for_cycles_rarely()
parse_once()
compose_once()


def pytest_collection_finish() -> None:
    keep_what_is_loaded()
