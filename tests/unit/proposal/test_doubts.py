"""What `init` says that the motion leaves open."""

import numpy as np
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.measurements.inventory import Place
from dr_lab.proposal.doubts import doubts_of
from dr_lab.proposal.search import Found
from dr_lab.proposal.survey import Series
from dr_lab.proposal.trial import Outcome, Reading
from dr_lab.proposal.words import read_name

NONE = np.zeros((1, 2))


def test_another_order_is_told_with_what_it_leaves() -> None:
    """Two orders that both leave next to nothing: which of them is right, the figures let the user judge."""
    outcome = Outcome(np.array([0.0004, 0.0002]), ((), ()), NONE, NONE, NONE, np.ones(2))
    readings, other = (Reading(0, 1.0), Reading(1, 1.0)), (Reading(1, 1.0), Reading(0, 1.0))
    found = Found(readings, outcome, (other,), (other,), (0.0018,))
    series = [Series(Place("", name, "", "column"), read_name("", name, ""), ()) for name in ("sh", "el")]
    settings = instantiate(compose("init", ["robot=a.xml", "logs=[a.csv]"]).proposal)
    (told,) = doubts_of(["shoulder", "elbow"], found, series, settings)
    assert "shoulder = el, elbow = sh leaves 0.18 % of the forces unexplained, this order 0.03 %" in told
    assert "Name columns after the joints." in told
