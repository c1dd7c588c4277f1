"""What was typed, by key."""

from dr_lab.sweeps.overrides import by_key


def test_nested_spelling_counts_as_the_plain_one() -> None:
    typed = [
        "+a=1",
        "~b",
        "c={arm.mass:{low:0.1}}",
        "c={arm.mass:{high:2}}",
        "d={x:1,y:2}",
        "e={x:{y:1},z:{w:2}}",
        "f={}",
    ]
    assert by_key(typed) == {
        "a": "1",
        "~b": "",
        "c.arm.mass.low": "0.1",
        "c.arm.mass.high": "2",
        "d": "{x:1,y:2}",
        "e": "{x:{y:1},z:{w:2}}",
        "f": "{}",
    }
