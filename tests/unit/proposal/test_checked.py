"""What init says of logs that seem wrong."""

from dr_lab.diagnosis.faults.data_faults import Fault
from dr_lab.proposal.checked import _by_message


def test_what_is_said_of_several_logs_in_the_same_words_is_said_once() -> None:
    off = [Fault("off", log, "motor", 0.0, 4.0, "motor: nothing moves.", "Leave it out.") for log in ("a", "b")]
    turned = Fault("sign", "a", "motor", 0.0, 4.0, "motor: turned.", "Write sign: -1.")
    assert _by_message([off[0], turned, off[1]]) == [
        "Logs a, b: motor: nothing moves. Leave it out.",
        "Log a: motor: turned. Write sign: -1.",
    ]
