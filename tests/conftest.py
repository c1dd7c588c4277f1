"""Fixtures that several folders of tests share."""

from recorder_samples import close_report, compare_report, furuta, look, overlay

__all__ = ["close_report", "compare_report", "furuta", "look", "overlay"]
