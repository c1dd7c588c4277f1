import re
from typing import Any

import pytest
from markdown_it import MarkdownIt

from dr_lab.reports.gap import GapReport
from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.reports.markdown import notes_list, report_markdown
from dr_lab.reports.plain import from_plain
from dr_lab.reports.tables import ranking_summary


def page(report: dict[str, Any]) -> str:
    return report_markdown(from_plain(GapReport, report))


def _cells(text: str, first: str) -> list[str]:
    """The cells of the table row whose first cell is `first`."""
    row = next(line for line in text.splitlines() if line.startswith(f"| {first} |"))
    return [cell.strip() for cell in row.strip("|").split(" | ")]


def test_close_report_says_everything_once(close_report: dict[str, Any]) -> None:
    text = page(close_report)
    assert (
        "**The missing effect is named:** `coulomb_friction@arm`. χ² on held-out logs: 355 (model as given) → 213.4"
        in text
    )
    assert "213.4 (calibrated) → 1.003 (+ coulomb_friction@arm); 1 is the noise floor." in text
    assert "What remains is noise." in text
    assert _cells(text, "model as given") == ["model as given", "355", "0.0712", "0.0501"]
    assert _cells(text, "calibrated") == ["calibrated", "213.4", "0.0512", "0.0301"]
    assert _cells(text, "`arm.position`")[1:] == ["rad", "0.0015", "0.0412", "0.00151", "0.0512", "0.00158", "99 %"]
    assert _cells(text, "`pole.mass` [kg]")[1:] == ["0.0262", "0.0261"]
    assert "- Model with coulomb_friction@arm: none. The model is at the noise floor." in text
    assert "The residual of `arm.position` follows `motor` after 4 ms: correlation 0.31" in text
    assert "`pole.position` follows" not in text
    assert _cells(text, "swing_05")[1:] == ["`motor`", "header", "0.0123 s", "21 ppm", "0.4 ms"]
    assert _cells(text, "+ coulomb_friction@arm")[1:] == ["1.003", "0.00158", "0.00152"]
    assert _cells(text, "1")[1:5] == ["`coulomb_friction@arm`", "named", "1.004", "95 % (93 % … 97 %)"]
    assert _cells(text, "`coulomb_friction@arm.torque`")[2] == "0.002003 ± 0.000010 N·m"
    assert "- `arm.position`, |qvel| < 0.3 rad/s: 71 % of its squared error" in text
    assert "it separates `coulomb_friction@arm` from `stribeck_friction@arm` by 9.1 σ" in text
    assert "- `swing_05` `arm.position`: 12 samples missing." in text
    assert "dr-lab view run=latest" in text


@pytest.mark.parametrize(
    ("verdict", "words"),
    [
        ("equivalent", "cannot tell apart `coulomb_friction@arm`, `stribeck_friction@arm`"),
        ("not_excited", "Not excited"),
        ("unexplained", "too little to be the cause"),
        ("none", "No missing effect"),
        (None, "**Added:** `coulomb_friction@arm`."),
    ],
)
def test_each_verdict_has_its_sentence(close_report: dict[str, Any], verdict: str | None, words: str) -> None:
    close_report["verdict"] = verdict
    close_report["ladder"][1]["rivals"] = ["stribeck_friction@arm"]
    assert words in page(close_report)


@pytest.mark.parametrize(("share", "told"), [(0.70, False), (0.71, True)])
def test_values_are_told_whose_uncertainty_is_mostly_the_time_steps(
    close_report: dict[str, Any], share: float, told: bool
) -> None:
    """A little more than half of the variance is, or less."""
    name = "coulomb_friction@arm.torque"
    row = close_report["ladder"][-1]["parameters"][name]
    row["std_by_step"] = share * row["std"]
    assert (f"- The time step that was simulated with gives most of the ± of `{name}`" in page(close_report)) == told


def test_effects_that_close_too_little_are_not_the_cause(close_report: dict[str, Any]) -> None:
    close_report |= {"verdict": "unexplained", "gap_closed": 0.47}
    told = "**Unexplained:** `coulomb_friction@arm` closes 47 % of a typical window's gap, too little to be the cause."
    assert told in page(close_report)
    assert "of what the calibrated model misses" not in page(close_report)  # how much they explain is no matter then
    close_report["gap_closed"] = -0.45
    told = "`coulomb_friction@arm` closes nothing of a typical window's gap, too little to be the cause."
    assert told in page(close_report)
    close_report["ladder"] = close_report["ladder"][:1]
    assert "**Unexplained:** a gap remains that no effect of the catalogue explains." in page(close_report)


def test_an_effect_with_another_law_is_the_nearest_and_not_the_cause(close_report: dict[str, Any]) -> None:
    told = "dead_zone@motor is the nearest of the catalogue, but its law is not the machine's."
    close_report |= {
        "verdict": "unexplained",
        "laws": [{"effect": "dead_zone@motor", "argument": "command", "explains": 0.9, "refuted": True, "told": told}],
    }
    assert f"**Unexplained:** {told}" in page(close_report)


@pytest.mark.parametrize("verdict", ["unexplained", "none", "not_excited"])
def test_nothing_is_called_named_where_the_verdict_names_nothing(close_report: dict[str, Any], verdict: str) -> None:
    close_report["verdict"] = verdict
    text = page(close_report)
    assert _cells(text, "1")[1:3] == ["`coulomb_friction@arm`", "best, not named"]
    assert "- Calibrated model: best, not named. coulomb_friction@arm lowers" in text
    assert "best, not named" in ranking_summary(from_plain(GapReport, close_report).judged.ranking, verdict, None)
    assert " named" not in text.replace("not named", "")
    close_report["ladder"] = close_report["ladder"][:1]
    assert "(+ " not in page(close_report)  # a candidate that was dropped again


def test_rankings_say_how_sure_their_intervals_are(close_report: dict[str, Any]) -> None:
    assert "| χ² removed in a typical window (interval) |" in page(close_report)  # of an older file
    assert "| χ² removed in a typical window (99.5 % interval) |" in page(close_report | {"confidence": 0.995})


def test_effects_that_stand_alone_are_named_beside_those_that_do_not(close_report: dict[str, Any]) -> None:
    first = close_report["ladder"][1]
    second = first | {"effects": ["coulomb_friction@arm", "payload@pole"], "rivals": ["armature@pole"]}
    close_report |= {"verdict": "equivalent", "ladder": [*close_report["ladder"], second]}
    text = page(close_report)
    assert "The missing effect is named:** `coulomb_friction@arm`." in text
    assert "cannot tell apart `payload@pole`, `armature@pole`" in text


def test_what_was_found_first_is_told_first(close_report: dict[str, Any]) -> None:
    first = close_report["ladder"][1] | {"rivals": ["stribeck_friction@arm"]}
    second = close_report["ladder"][1] | {"effects": ["coulomb_friction@arm", "payload@pole"]}
    close_report |= {"verdict": "equivalent", "ladder": [close_report["ladder"][0], first, second]}
    told = "cannot tell apart `coulomb_friction@arm`, `stribeck_friction@arm`. **Named beside them:** `payload@pole`."
    assert told in page(close_report)


@pytest.mark.parametrize(
    ("windows", "gap", "told"),
    [
        (
            2,
            -0.5,
            "On 2 windows that chose nothing, too few to be sure, a typical window's gap is 1.5 times as wide",
        ),
        (3, 0.8, "On 3 windows that chose nothing, too few to be sure, the same shows: 80 % of a typical window's gap"),
        (1, 0.041, "On 1 window that chose nothing, too few to be sure, only 4.1 % of a typical window's gap"),
    ],
)
def test_what_few_windows_say_is_told_as_it_is(
    close_report: dict[str, Any], windows: int, gap: float, told: str
) -> None:
    close_report |= {
        "explained": {"share": 0.9, "interval": [0.7, 0.97]},
        "confirmation": {
            "status": "undecided",
            "predicted_worse": False,
            "windows": windows,
            "chi2_before": 37.0,
            "chi2_after": 30.0,
            "gap_closed": gap,
            "gain": gap,
            "gain_ci": [None, None],
            "evidence": 1.2,
            "evidence_low": None,
        },
    }
    assert told in page(close_report)


def test_no_window_that_could_confirm_is_told(close_report: dict[str, Any]) -> None:
    close_report["confirmation"] = {"status": "undecided", "predicted_worse": False, "windows": 0}
    assert "No window was left that chose nothing and could confirm what was added." in page(close_report)


def test_one_window_contradicts(close_report: dict[str, Any]) -> None:
    gain = {"chi2_before": 37.0, "chi2_after": 370.0, "gap_closed": -9.0, "gain": -9.0, "gain_ci": [None, None]}
    close_report["confirmation"] = {
        "status": "contradicted",
        "predicted_worse": False,
        "windows": 1,
        **gain,
        "evidence": -18.0,
        "evidence_low": None,
    }
    told = "1 window that chose nothing contradicts that: χ² goes from 37 to 370 there."
    assert told in page(close_report)


def test_several_effects_are_named_in_the_plural(close_report: dict[str, Any]) -> None:
    second = close_report["ladder"][1] | {"effects": ["coulomb_friction@arm", "payload@pole"]}
    close_report["ladder"] = [*close_report["ladder"], second]
    assert "**The missing effects are named:** `coulomb_friction@arm`, `payload@pole`." in page(close_report)


def test_one_effect_at_more_than_two_sites_is_named_once(close_report: dict[str, Any]) -> None:
    effects = ["coulomb_friction@arm", "payload@pole", "coulomb_friction@pole", "coulomb_friction@hand"]
    close_report["ladder"] += [close_report["ladder"][1] | {"effects": effects[:k]} for k in (2, 3, 4)]
    told = "**The missing effects are named:** `coulomb_friction` at `arm`, `pole` and `hand`, `payload@pole`."
    assert told in page(close_report)


def test_the_places_of_failure_say_of_which_model(close_report: dict[str, Any]) -> None:
    assert "## Where the calibrated model fails" in page(close_report)
    del close_report["as_given"]
    assert "## Where the model as given fails" in page(close_report)


def test_diagnose_without_an_added_rung_shows_the_candidate(close_report: dict[str, Any]) -> None:
    close_report["ladder"] = close_report["ladder"][:1]
    assert "213.4 (calibrated) → 1.004 (+ coulomb_friction@arm)" in page(close_report)


def test_unexplained_rest_is_told_apart_from_the_verdict(close_report: dict[str, Any]) -> None:
    close_report["remaining"] = {"status": "unexplained", "chi2": 3.21}
    text = page(close_report)
    assert "The missing effect is named" in text
    assert "What remains (χ² 3.21) is above the noise floor" in text


def test_calibration_alone_is_set_beside_the_model_as_given(close_report: dict[str, Any]) -> None:
    fit = close_report | {"verb": "fit", "verdict": None, "ladder": close_report["ladder"][:1], "ranking": []}
    text = page(fit)
    assert "**Calibrated on the logs.** χ² on held-out logs: 355 (model as given) → 213.4 (calibrated)" in text
    assert _cells(text, "`arm.position`")[3:7] == ["0.0611", "0.0412", "0.0712", "0.0512"]


def test_errors_on_fit_logs_are_not_called_held_out(close_report: dict[str, Any]) -> None:
    close_report["rungs"] = []
    assert "held-out" in page(close_report | {"logs": {"fit": ["a"], "held_out": ["b"]}})
    text = page(close_report | {"logs": {"fit": ["a", "b"], "held_out": []}})
    assert "χ² on fit logs: 355 (model as given)" in text
    assert "## Error by channel, on fit logs" in text
    assert "held-out" not in text.lower()


def test_long_ladders_are_told_by_their_ends(close_report: dict[str, Any]) -> None:
    effects = ["coulomb_friction@arm", "payload@pole"]
    close_report["ladder"].append(close_report["ladder"][1] | {"effects": effects})
    ends = "355 (model as given) → 213.4 (calibrated) → "
    assert f"{ends}1.003 (+ coulomb_friction@arm) → 1.003 (+ payload@pole); 1 is" in page(close_report)
    close_report["ladder"].append(close_report["ladder"][1] | {"effects": [*effects, "spring@arm"]})
    text = page(close_report)
    assert f"{ends}… → 1.003 (+ spring@arm); 1 is" in text
    assert "named:** `coulomb_friction@arm`, `payload@pole`, `spring@arm`." in text


def test_diverged_windows_are_counted(close_report: dict[str, Any]) -> None:
    close_report["ladder"][0]["held_out"]["infeasible_windows"] = 3
    text = page(close_report)
    assert _cells(text, "calibrated")[-1] == "3"
    assert _cells(text, "+ coulomb_friction@arm")[-1] == "0"


def test_compare_report_has_no_empty_section(compare_report: dict[str, Any]) -> None:
    text = page(compare_report)
    assert "Candidates" not in text
    assert "## Notes" not in text
    assert _cells(text, "0.3 s") == ["0.3 s", "0.003", "0.006"]
    assert not re.search(r"^## [^\n]+\n\n(##|$)", text, flags=re.M)


def test_many_channels_keep_the_ladder_narrow(close_report: dict[str, Any]) -> None:
    close_report["noise"] |= {f"j{i}.position": {"std": 0.1, "unit": "rad", "source": "given"} for i in range(4)}
    text = page(close_report)
    assert _cells(text, "model as given") == ["model as given", "355"]
    assert _cells(text, "`j3.position`")[3] == "–"


def test_tables_parse_with_bars_in_names(close_report: dict[str, Any]) -> None:
    close_report["ladder"][1]["parameters"]["a|b"] = {"value": 1.0, "std": None, "unit": ""}
    close_report["ladder"][1]["parameters"]["pole.mass"]["cv_percent"] = 3.4
    html = MarkdownIt("commonmark").enable("table").render(page(close_report))
    assert '<td style="text-align:left"><code>a|b</code></td>' in html
    assert "3.4 %" in html


def test_a_value_at_its_bound_has_no_interval(close_report: dict[str, Any]) -> None:
    row, own = close_report["ladder"][1]["parameters"], close_report["ranking"][0]["parameters"]
    row["pole.mass"] |= {"value": 0.2, "at_bound": True}
    own["coulomb_friction@arm.torque"] |= {"value": 0.0, "at_bound": True}
    text = page(close_report)
    assert _cells(text, "`pole.mass`")[2] == "0.2 kg, at its bound"
    assert _cells(text, "1")[5] == "torque 0 N·m, at its bound"


def test_what_free_parameters_absorb_is_no_rival(close_report: dict[str, Any]) -> None:
    close_report["ranking"][1] |= {"status": "equivalent", "absorbed_by_parameters": True}
    assert _cells(page(close_report), "2")[2] == "absorbed"


def test_a_note_names_its_signal_once() -> None:
    notes = [
        NoteEntry("arm.position: 4 samples came out of order and were sorted.", "disorder", "a", "arm.position"),
        NoteEntry("a.csv ends within a row.", "cut", "a", ""),
    ]
    told = notes_list(notes).splitlines()
    assert told == [
        "- `a` `arm.position`: 4 samples came out of order and were sorted.", "- `a`: a.csv ends within a row."
    ]  # fmt: skip


def test_a_channel_without_a_unit_has_plain_numbers(close_report: dict[str, Any]) -> None:
    close_report["noise"]["arm.position"]["unit"] = "1"
    text = page(close_report)
    assert "| `arm.position` | 0.0015 | estimated | 2.1e-5 |" in text
    assert "predicted RMSE arm.position |" in text
