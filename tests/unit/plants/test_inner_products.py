"""Inner products of one choice at a time are those of all columns."""

import numpy as np

from dr_lab.plants.alike.inner_products import InnerProducts

COMMON, SIZES = 3, [2, 1, 4, 1, 2]


def test_each_choice_has_the_inner_products_of_all_columns() -> None:
    rng = np.random.default_rng(0)
    parts = [rng.standard_normal((count, COMMON + sum(SIZES))) for count in (40, 25)]
    one, other = (InnerProducts.of(rows, COMMON, SIZES) for rows in parts)
    whole, place = parts[0].T @ parts[0] + parts[1].T @ parts[1], COMMON
    for size, found in zip(SIZES, (one + other).of_choices(), strict=True):
        columns = [*range(COMMON), *range(place, place + size)]
        np.testing.assert_allclose(found, whole[np.ix_(columns, columns)], rtol=1e-12, atol=1e-12)
        place += size


def test_without_choices_the_common_columns_are_left() -> None:
    rows = np.random.default_rng(1).standard_normal((10, COMMON))
    found = InnerProducts.of(rows, COMMON, [])
    np.testing.assert_allclose(found.common, rows.T @ rows)
    assert found.of_choices() == []
