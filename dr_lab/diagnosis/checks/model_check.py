"""Settings of what is checked of a model before anything is blamed on the machine; values in conf/comparison."""

from dataclasses import dataclass
from typing import Annotated

from dr_lab.bounds import Confidence, Count, Natural, NotNegative, Positive, Share, at_least, require_bounds
from dr_lab.diagnosis.fit.right_model import most_chi2


@dataclass(frozen=True)
class ModelCheckSettings:
    """How a model is tried on logs that it made itself, and how fine its time step must be.

    Attributes:
        windows: windows in which it is tried, spread over the logs; 0 leaves the trial out. Finer steps are tried in as
            many, at least in one.
        lead: s that it is simulated before each of them, so that its hidden states are its own.
        largest_chi2: of a channel in its own logs, where samples are many.
        confidence: that a right model is not refused for the scatter of few samples.
        seed: of the noise that is added to its logs.
        least_share: share of the noise that the time step may move an output by.
        finest: largest number of parts that a step is divided into.
        converging: share of the step's error that may be left of a finer one if the step is its cause.
        hopeless: times the squares that noise alone leaves, beyond which a calibration that is to leave no more than
            noise is given up.
        chain_positions: positions of each log in which closed chains are tried.
        chain_gap: times what noise alone opens them, beyond which the measured joints contradict them.
        chain_impedance: share of the acceleration that would part a closed chain which its constraint takes away, where
            nobody chose how soft it is.
        chain_mended: share of the contradiction that another zero or direction of a channel may leave.

    Raises:
        ConfigError: a number is too small.
    """

    windows: Natural
    lead: NotNegative
    largest_chi2: Positive
    confidence: Confidence
    seed: Natural
    least_share: Positive
    finest: Count
    converging: Share
    hopeless: Annotated[float, at_least(1.0)]
    chain_positions: Count
    chain_gap: Positive
    chain_impedance: Share
    chain_mended: Share

    def __post_init__(self) -> None:
        require_bounds(self, "model_check")

    def most_chi2(self, freedom: float) -> float:
        """Largest χ² per degree of freedom that a right model leaves."""
        return most_chi2(freedom, self.largest_chi2, self.confidence)
