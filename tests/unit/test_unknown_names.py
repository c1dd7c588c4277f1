"""What an unknown name is told."""

import pytest

from dr_lab.errors import MOST_LISTED, UnknownNameError


def test_the_closest_name_is_offered_and_all_are_listed() -> None:
    error = UnknownNameError("joint", "amr", ["pole", "arm", "wrist/1"], "the model")
    assert str(error) == "There is no joint 'amr' in the model. Did you mean 'arm'? Available: arm, pole, wrist/1."


def test_of_many_names_those_of_a_folder_are_listed_as_one() -> None:
    names = ["none", *(f"arm/spring_{number}" for number in range(MOST_LISTED))]
    error = UnknownNameError("effect", "arm/sprng_7", names, "the group")
    assert str(error).endswith(" Did you mean 'arm/spring_7'? Available: arm/…, none.")
    assert len(error.available) == MOST_LISTED + 1


def test_of_many_names_without_folders_those_of_one_first_word_are_listed_together() -> None:
    names = ["none", *(f"{word}_{number}" for word in ("arm", "wheel") for number in range(MOST_LISTED))]
    error = UnknownNameError("case", "arm_999", names, "the benchmark")
    assert str(error).endswith("Did you mean 'arm_9'? Available: arm_…, none, wheel_….")


@pytest.mark.parametrize(
    ("given", "hint"),
    [
        ("lugre", " Did you mean 'lugre_friction'?"),
        ("arm", " Did you mean 'arm_weight' or 'forearm_load'?"),
        ("e", ""),
        ("xyz", ""),
    ],
)
def test_a_part_of_a_name_offers_those_that_hold_it(given: str, hint: str) -> None:
    """By likeness alone `lugre` is too far from `lugre_friction`; a letter that every name holds means none."""
    names = ["forearm_load", "lugre_friction", "arm_weight", *(f"effect{number}" for number in range(6))]
    text = str(UnknownNameError("effect", given, names, "the group"))
    assert text.startswith(f"There is no effect {given!r} in the group.{hint} Available: ")


def test_a_first_word_that_one_name_has_alone_does_not_stand_for_it() -> None:
    names = ["lugre_friction", *(f"arm_{number}" for number in range(MOST_LISTED))]
    assert str(UnknownNameError("effect", "?", names, "the group")).endswith("Available: arm_…, lugre_friction.")
