import pytest
from diagnosis_machines import solver_settings

from dr_lab.diagnosis.fit.damping import Damping

SETTINGS = solver_settings(damping=0.01, damping_up=8.0, damping_down=4.0, damping_max=1.0)


@pytest.mark.parametrize(
    ("share", "held_back", "after"),
    [(1.0, False, 0.0025), (0.5, False, 0.0025), (1.0, True, 0.01 / 64), (0.25, True, 0.08)],
)
def test_it_falls_after_good_steps_and_faster_where_it_held_them_back(
    share: float, after: float, *, held_back: bool
) -> None:
    damping = Damping(SETTINGS)
    damping.after_success(share, held_back=held_back)
    assert damping.now == pytest.approx(after)


def test_it_grows_after_failures_from_where_it_began_at_least_until_a_descent_ends() -> None:
    damping = Damping(SETTINGS)
    damping.after_success(1.0, held_back=True)
    seen = list[float]()
    while not damping.largest:
        damping.after_failure()
        seen.append(damping.now)
    assert seen == pytest.approx([0.01, 0.08, 0.64, 5.12])
