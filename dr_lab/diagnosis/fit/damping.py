"""The damping of a descent, and how it goes up and down with its steps."""

from dr_lab.diagnosis.settings import SolverSettings

_FAR = 0.5  # of a step; where less of it fits best, damping grows
_FASTER = 3  # falls at once where damping holds right steps back along a valley, as where two masses trade places


class Damping:
    """Levenberg–Marquardt λ, relative to the diagonal of the normal equations.

    Args:
        settings: where it begins, its factors, and its largest value.
    """

    def __init__(self, settings: SolverSettings) -> None:
        self._settings = settings
        self.now = settings.damping

    @property
    def largest(self) -> bool:
        """Whether a descent ends for it."""
        return self.now > self._settings.damping_max

    def after_failure(self) -> None:
        """Grow after a step that raised the cost."""
        self.now = max(self._settings.damping_up * self.now, self._settings.damping)

    def after_success(self, share: float, *, held_back: bool) -> None:
        """Fall after a step, or grow where only a small share of it was good.

        Args:
            share: of the step.
            held_back: whether the step gained what was foretold, which is much less than what one without damping
                would; then it falls faster.
        """
        settings = self._settings
        if share < _FAR:
            self.now *= settings.damping_up
        else:
            self.now /= settings.damping_down ** (_FASTER if held_back else 1)
