"""Fixtures that several folders of tests share."""

import pytest
from recorder_samples import close_report, compare_report, furuta, look, overlay

__all__ = ["close_report", "compare_report", "furuta", "look", "overlay"]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Keep the tests of a module in one process, which then makes its fixtures once; contract tests have none."""
    for item in items:
        if item.path.parent.name != "contract":
            item.add_marker(pytest.mark.xdist_group(item.path.stem))
