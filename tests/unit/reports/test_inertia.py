from dr_lab.reports.inertia import inertia_told
from dr_lab.reports.inertia_entries import BodyEntry, InertiaEntry

BODY = BodyEntry(3.02, 0.04, (0.01, -0.03, 0.1), (0.001, 0.001, 0.002))


def test_it_says_what_the_logs_know_and_what_the_prior_holds() -> None:
    found = InertiaEntry(
        parameters=70,
        rank=48,
        known=43,
        condition=212.0,
        chosen=("link2.inertial.mass",),
        held=("link1.inertial.mass", "link1.inertial.shift_x", "link2.inertial.mass"),
        best=(),
        worst=({"link1.inertial.mass": 0.8, "link2.inertial.mass": -0.6},),
        bodies={"link1": BODY},
    )
    told = inertia_told(found)
    assert told.startswith(
        "The logs know 43 of 70 combinations of the inertial parameters (condition 212: moderately conditioned). "
        "Poorly known: 0.80 `link1.inertial.mass` − 0.60 `link2.inertial.mass`. "
        "22 more change nothing that was measured, whatever the noise. "
        "A weak prior holds these near the model file, for want of data: `link1` mass, shift_x; `link2` mass.\n\n"
    )
    assert "| `link1` | 3.020 ± 0.040 kg | 0.0100 ± 0.0010 m, -0.0300 ± 0.0010 m, 0.1000 ± 0.0020 m |" in told


def test_where_all_is_known_nothing_is_held() -> None:
    found = InertiaEntry(10, 10, 10, 40.0, (), (), (), (), {"link": BODY})
    first = inertia_told(found).partition("\n")[0]
    assert first == "The logs know 10 of 10 combinations of the inertial parameters (condition 40: well conditioned)."


def test_nothing_is_said_of_models_without_them() -> None:
    assert inertia_told(None) == ""
