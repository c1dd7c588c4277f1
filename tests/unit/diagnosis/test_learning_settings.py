from dataclasses import replace

import pytest
from diagnosis_machines import comparison_settings

from dr_lab.errors import ConfigError


@pytest.mark.parametrize(
    ("changes", "told"),
    [({"most": 0.5}, "learning.most is 0.5"), ({"widths": []}, "learning.widths is"), ({"sizes": [0.0]}, "above 0")],
)
def test_a_force_is_learned_with_numbers_that_let_it_be(changes: dict[str, object], told: str) -> None:
    """Its factor begins at 1, which its bounds must hold."""
    with pytest.raises(ConfigError, match=told):
        replace(comparison_settings().learning, **changes)
