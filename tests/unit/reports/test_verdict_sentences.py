"""The sentences of a verdict that hold numbers: how a prediction changes, how far intervals reach."""

from typing import Any

import pytest

from dr_lab.reports.gap import GapReport
from dr_lab.reports.markdown import report_markdown
from dr_lab.reports.plain import from_plain
from dr_lab.reports.verdict import verdict_markdown


def verdict(report: dict[str, Any]) -> str:
    return verdict_markdown(from_plain(GapReport, report))


def explaining(report: dict[str, Any], **explained: float) -> dict[str, Any]:
    return report | {"explained": {"share": 0.32, "low": -1.25e8, "high": 1.0} | explained}


def test_a_prediction_is_told_without_and_with_what_was_added(close_report: dict[str, Any]) -> None:
    for rung, error in zip(close_report["ladder"], (0.0354, 0.0224), strict=True):
        rung["held_out"]["rmse_predicted"] = {"arm.position": error}
    told = verdict(explaining(close_report, low=0.1))
    assert "It explains 32 % (10 % … 100 %) of what the calibrated model misses. " in told
    assert "`arm.position` is predicted within 0.0354 rad RMS without it and 0.0224 with it. χ² on" in told
    close_report["ladder"][-1]["rivals"] = ["spring@arm"]
    assert "The first explains 32 % (10 % … 100 %)" in verdict(explaining(close_report, low=0.1))
    close_report["ladder"][-1]["effects"] = ["coulomb_friction@arm", "payload@pole"]
    told = verdict(explaining(close_report))
    assert "Together they explain 32 %" in told
    assert "0.0354 rad RMS without them and 0.0224 with them." in told


@pytest.mark.parametrize(
    ("after", "words"),
    [
        (4594.0, "misses in a typical window; the squares of all windows together, most of them in few, fall by 43 %."),
        (9000.0, "misses in a typical window; the squares of all windows together, most of them in few, do not fall."),
        (20.0, "misses. "),
    ],
)
def test_a_share_of_typical_windows_is_told_as_such(close_report: dict[str, Any], after: float, words: str) -> None:
    """χ² falls by 43 %, or not at all, where 95 % of a typical window's are explained."""
    for rung, chi2 in zip(close_report["ladder"], (8127.0, after), strict=True):
        rung["held_out"]["chi2"] = chi2
    assert words in verdict(explaining(close_report, share=0.95, low=0.9))


def test_a_channel_whose_noise_is_unknown_has_no_unit(close_report: dict[str, Any]) -> None:
    for rung, error in zip(close_report["ladder"], (2.0, 1.0), strict=True):
        rung["held_out"]["rmse_predicted"] = {"other": error}
    assert "`other` is predicted within 2 RMS without it and 1 with it." in verdict(explaining(close_report))


def test_percentages_out_of_reason_are_not_written_out(close_report: dict[str, Any]) -> None:
    assert "It explains 32 % (below -1000 % … 100 %) of" in verdict(explaining(close_report))
    close_report["ranking"][0]["gain_ci"] = [-125462821.61, 1.0]
    close_report["ladder"][1]["parameters"]["pole.mass"]["cv_percent"] = 36568.0
    told = report_markdown(from_plain(GapReport, close_report))
    assert "(below -1000 % … 100 %)" in told
    assert "| above 1000 % |" in told


@pytest.mark.parametrize(
    ("predicted", "words"),
    [
        ({"a": [4.0, 2.0]}, "held-out logs falls by 60 %)."),
        ({"a": [4.0, 2.0], "b": [0.0, 0.0]}, "held-out logs falls by 60 %)."),
        (
            {"a": [4.0, 2.0], "b": [4.0, 1.0]},
            "falls by 60 %; of the log that gains least it falls by 75 %)",
        ),
        ({"a": [4.0, 2.0], "b": [1.0, 9.0]}, "of the log that gains least it grows more than tenfold)"),
        ({"a": [4.0, 2.0], "b": [2.0, 4.0]}, "of the log that gains least it grows by 300 %)"),
    ],
)
def test_the_log_that_gains_least_is_one_of_several(
    close_report: dict[str, Any], predicted: dict[str, list[float]], words: str
) -> None:
    row = {"joint": "arm", "effect": "residual_force@arm", "depends_on": ["angle of arm"], "accepted": True}
    close_report["learned"] = [row | {"removes": 0.6, "predicted": predicted}]
    assert words in verdict(close_report)


def unneeded(report: dict[str, Any], site: str, taker: str) -> dict[str, Any]:
    """A calibration that leaves noise alone; an effect that cannot be told from one of its parameters."""
    rung = report["ladder"][0]
    rung["parameters"] = {
        "arm.mass": {"value": 0.12, "std": 0.001, "unit": "kg"},
        "arm.damping": {"value": 0.0101, "std": 0.001, "unit": "N·m·s/rad"},
    }
    report["as_given"]["parameters"] = {
        "arm.mass": {"value": 0.1, "std": None, "unit": "kg"},
        "arm.damping": {"value": 0.01, "std": None, "unit": "N·m·s/rad"},
    }
    row = report["ranking"][0] | {"effect": "torque_scale", "site": site, "replaced_by": {taker: 1.2}}
    return report | {"verdict": "none", "ladder": [rung], "ranking": [row]}


def test_a_mass_that_took_over_what_a_motor_may_have_is_told(close_report: dict[str, Any]) -> None:
    told = verdict(unneeded(close_report, "motor", "arm.mass"))
    assert "Calibrating changed `arm.mass` 0.1 → 0.12 kg (+20 %). **`torque_scale@motor` would look the same" in told
    assert "as the change of `arm.mass`:** measure what you can" in told
    assert "arm.damping" not in told  # changed by a tenth of its standard deviation


@pytest.mark.parametrize(("site", "taker"), [("motor", "arm.damping"), ("arm", "arm.mass")])
def test_what_did_not_change_or_is_the_same_thing_stands_for_no_effect(
    close_report: dict[str, Any], site: str, taker: str
) -> None:
    told = verdict(unneeded(close_report, site, taker))
    assert "Calibrating changed `arm.mass`" in told
    assert "would look the same" not in told


def test_what_trades_is_told_once_beside_the_parameters(close_report: dict[str, Any]) -> None:
    told = "a@x.mean and b@x.torque trade: the logs know their sum."
    close_report["notes"] = [*close_report["notes"], {"message": told, "kind": "trade"}]
    text = report_markdown(from_plain(GapReport, close_report))
    assert text.count(told) == 1
    assert told in text.partition("## Parameters\n")[2].partition("\n## ")[0]


def begun_with_friction(report: dict[str, Any], *more: list[str], **rest: object) -> dict[str, Any]:
    """A report of a model that came with dry friction, and models that have more than that."""
    own = {"effects": ["coulomb_friction@arm"], "rivals": []}
    first, last = report["ladder"]
    ladder = [first | own, *(last | {"effects": [*own["effects"], *effects], "rivals": []} for effects in more)]
    return report | {"as_given": report["as_given"] | own, "ladder": ladder, "ranking": []} | rest


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        (None, "**Calibrated on the logs.** χ² on held-out logs: 355 (model as given) → 213.4 (calibrated); 1"),
        ("unexplained", "**Unexplained:** a gap remains that no effect of the catalogue explains."),
    ],
)
def test_what_a_model_came_with_was_not_added(close_report: dict[str, Any], kind: str | None, words: str) -> None:
    told = verdict(begun_with_friction(close_report, verdict=kind))
    assert words in told
    assert "coulomb_friction" not in told


@pytest.mark.parametrize(("chi2", "little"), [(1.36, True), (2.1, False)])
def test_a_gap_below_the_noise_is_called_little(close_report: dict[str, Any], chi2: float, little: bool) -> None:
    report = begun_with_friction(close_report, verdict="unexplained")
    report["ladder"][-1]["held_out"]["chi2"] = chi2
    assert ("**Unexplained, though little:** a gap below the noise remains" in verdict(report)) == little


def test_a_calibration_that_got_worse_is_not_blamed_on_what_the_model_came_with(close_report: dict[str, Any]) -> None:
    close_report["as_given"]["held_out"]["chi2"] = 100.0
    left = {"status": "unexplained", "chi2": 213.4}
    told = verdict(begun_with_friction(close_report, verdict=None, remaining=left))
    assert told.startswith("**The calibrated model predicts the held-out logs worse than the model as given: χ² 100 →")
    assert "coulomb_friction" not in told


@pytest.mark.parametrize(
    ("chi2", "said"),
    [(0.98, "What remains is noise."), (0.04, "What remains is 0.2 times the noise that was estimated")],
)
def test_noise_that_was_estimated_too_large_is_told(close_report: dict[str, Any], chi2: float, said: str) -> None:
    told = verdict(close_report | {"remaining": {"status": "at_floor", "chi2": chi2}})
    assert said in told
    assert ("Give `noise_std`" in told) == (chi2 < 0.5)


def test_what_was_added_to_the_effects_of_a_model_is_named_alone(close_report: dict[str, Any]) -> None:
    told = verdict(explaining(begun_with_friction(close_report, ["spring@arm"]), low=0.1))
    assert told.startswith("**The missing effect is named:** `spring@arm`. It explains 32 % (10 % … 100 %) of what")
    assert "355 (model as given) → 213.4 (calibrated) → 1.003 (+ spring@arm); 1 is" in told
    report = begun_with_friction(close_report, ["spring@arm"], verdict="equivalent")
    report["ladder"][-1]["rivals"] = ["spring@pole"]
    assert verdict(report).startswith(
        "**Equivalent effects:** these logs cannot tell apart `spring@arm`, `spring@pole`. χ² on"
    )


def test_a_model_that_is_only_compared_is_the_one_given_with_its_effects(compare_report: dict[str, Any]) -> None:
    compare_report["ladder"][0]["effects"] = ["coulomb_friction@arm"]
    told = verdict(compare_report)
    assert told.startswith("**Measured against the model.** χ² on held-out logs: 355 (model as given); 1 is")


def test_a_learned_force_that_makes_it_worse_is_not_blamed_on_the_model_before_it(close_report: dict[str, Any]) -> None:
    first = close_report["ladder"][0]
    worse = first["held_out"] | {"chi2": 900.0, "infeasible_windows": 3}
    learned = first | {"effects": ["residual_force@arm"], "learned": True, "held_out": worse}
    left = {"verdict": "unexplained", "ranking": [], "remaining": {"status": "unexplained", "chi2": 213.4}}
    told = verdict(close_report | left | {"ladder": [first, learned]})
    assert told.startswith("**Unexplained:** a gap remains")
    assert "→ 213.4 (calibrated) → 900 (+ residual_force@arm, learned); 1 is the noise floor. What remains (χ²" in told


def test_what_is_worse_without_the_learned_force_is_told_by_its_own_error(close_report: dict[str, Any]) -> None:
    first, last = close_report["ladder"]
    last["held_out"] |= {"chi2": 400.0, "infeasible_windows": 2}
    better = first["held_out"] | {"chi2": 100.0}
    learned = last | {"effects": [*last["effects"], "residual_force@arm"], "learned": True, "held_out": better}
    left = {"verdict": "unexplained", "remaining": {"status": "unexplained", "chi2": 400.0}}
    told = verdict(close_report | left | {"ladder": [first, last, learned]})
    assert told.startswith("**The model with `coulomb_friction@arm` predicts the held-out logs worse than the model as")
    assert "χ² 355 → 400. Do not use it.**" in told
    assert "The simulation diverges in 2 of the windows that score. What remains (χ² 400)" in told


def test_what_no_log_tells_apart_stands_beside_what_is_named(close_report: dict[str, Any]) -> None:
    same = "No log tells `asymmetric_friction@arm` from `coulomb_friction@arm` (1 N·m) and others together."
    close_report["notes"] = [{"message": same, "kind": "together"}]
    assert f"named:** `coulomb_friction@arm`. {same} " in verdict(close_report)


def test_what_the_catalogue_may_explain_besides_is_not_denied(close_report: dict[str, Any]) -> None:
    """A ladder that ended at its most effects, and verbs that try nothing beside what they add."""
    close_report["remaining"] = {"status": "unexplained", "chi2": 4.0, "coloured": False}
    close_report["rungs"][-1] |= {"verdict": "named", "chosen": ["actuator_delay@motor"]}
    left = "What remains (χ² 4) is above the noise floor: 2 times the sensors' noise. "
    more = "`actuator_delay@motor` explains more of it, but `most` left no room: raise it."
    assert verdict(close_report).endswith(left + more)
    close_report["rungs"][-1]["effects"] = ["coulomb_friction@arm", "payload@pole"]  # does not predict better: dropped
    assert "not explained by anything in the catalogue" in verdict(close_report)
    for verb in ("diagnose", "add"):
        told = verdict(close_report | {"verb": verb})
        assert f"{left}No other effect was tried beside what was added: `dr-lab close` does that." in told


def test_a_shift_that_is_too_short_to_be_named_stands_beside_what_remains(close_report: dict[str, Any]) -> None:
    close_report["remaining"] = {"status": "unexplained", "chi2": 3.99, "coloured": False}
    assert "not explained by anything in the catalogue: 2 times the sensors' noise." in verdict(close_report)
    short = "`actuator_delay@motor` (1.14 ms) would leave χ² 1.049. It is not named."
    close_report["notes"] = [{"message": short, "kind": "short_shift"}]
    assert f"not explained by anything but a shift in time: 2 times the sensors' noise. {short}" in verdict(
        close_report
    )


def test_what_a_user_named_is_told_as_added_and_not_as_found(close_report: dict[str, Any]) -> None:
    close_report["verb"] = "add"
    told = verdict(explaining(close_report, low=0.1))
    assert "missing effect is named" not in told
    assert told.startswith(
        "**Added as asked:** `coulomb_friction@arm`. The logs support it; no other effect was tried. "
        "It explains 32 % (10 % … 100 %) of what the calibrated model misses."
    )
    close_report["ladder"][-1]["effects"] = ["coulomb_friction@arm", "payload@pole"]
    told = verdict(close_report)
    assert "`coulomb_friction@arm`, `payload@pole`. The logs support them; no others were tried." in told


def test_a_calibration_is_worse_only_by_more_than_noise_is_known_to(close_report: dict[str, Any]) -> None:
    last, given = close_report["ladder"][-1], close_report["as_given"]
    left = {"verdict": "unexplained", "ranking": [], "remaining": {"status": "unexplained", "chi2": 1.404}}
    for after, worse in ((1.404, False), (1.6, True)):
        for model, chi2 in ((given, 1.402), (last, after)):
            model["held_out"] |= {"chi2": chi2, "infeasible_windows": 0}
        assert ("Do not use it" in verdict(close_report | left)) == worse
