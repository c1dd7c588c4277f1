from typing import Any

from dr_lab.reports.gap import GapReport
from dr_lab.reports.markdown import report_markdown
from dr_lab.reports.plain import from_plain


def page(report: dict[str, Any]) -> str:
    return report_markdown(from_plain(GapReport, report))


def test_an_experiment_that_decides_nothing_is_not_recommended(close_report: dict[str, Any]) -> None:
    close_report["next_experiment"] |= {"sigma": 0.25, "needed": 5.0, "taken": 0.99}
    text = page(close_report)
    assert "Play `next_experiment.csv`" not in text
    assert "No command that was tried separates `coulomb_friction@arm` from `stribeck_friction@arm`" in text
    assert "`next_experiment.safety.margin`" in text


def test_an_experiment_says_how_it_is_played(close_report: dict[str, Any]) -> None:
    played = {"rate": 100.0, "duration": 6.0, "start": {"arm.position": 0.25}, "hold": {"motor": 0.5}, "taken": 0.97}
    close_report["next_experiment"] |= {"units": {"motor": "V"}, **played}
    text = page(close_report)
    assert "separates `coulomb_friction@arm` from `stribeck_friction@arm` by 9.1 σ" in text
    assert "Bring the machine to rest at arm 0.25 (rad or m), held by motor 0.5 V." in text
    assert "100 a second for 6 s" in text
    assert "97 %" in text


def test_an_experiment_may_sharpen_parameters(close_report: dict[str, Any]) -> None:
    rows = [("pole.mass", 0.01, 0.002), ("arm.mass", 0.01, 0.0099)]
    sharpens = [{"parameter": name, "unit": "kg", "std": std, "std_after": after} for name, std, after in rows]
    close_report["next_experiment"] = {"sharpens": sharpens, "command_file": "next_experiment.csv"}
    text = page(close_report)
    assert "Play `next_experiment.csv`: with the logs it would sharpen `pole.mass` from ± 0.01 to ± 0.002 kg." in text
    close_report["next_experiment"]["sharpens"] = [sharpens[0] | {"unit": "1"}]
    assert "sharpen `pole.mass` from ± 0.01 to ± 0.002." in page(close_report)
    close_report["next_experiment"]["sharpens"] = sharpens[1:]
    assert "No command that was tried would tell `arm.mass` better" in page(close_report)


def test_where_none_may_be_played_the_reason_is_told(close_report: dict[str, Any]) -> None:
    close_report["next_experiment"] = {"separates": ["a@x", "b@y"], "reason": "the range of elbow"}
    text = page(close_report)
    assert "No experiment that separates `a@x` from `b@y` may be played" in text
    assert "would leave the range of elbow" in text


def test_what_a_regression_reaches_is_no_limit_of_what_can_be_explained(close_report: dict[str, Any]) -> None:
    """Dry friction is a force of the state; a forest on few windows finds less of it than the effect explains."""
    force = {"joint": "arm", "unit": "N·m", "rms_first": 9.53e-4, "rms_last": 3.77e-5, "noise": 4.74e-5}
    close_report["missing_force"] = [force | {"explained": 0.998, "ceiling": 0.62, "left": None}]
    assert "99.8 % explained (a regression on the measured state: 62 %)." in page(close_report)
    close_report["missing_force"] = [force | {"explained": -0.79, "ceiling": 0.62, "left": None}]
    assert "none of it explained (a regression on the measured state: 62 %)." in page(close_report)
