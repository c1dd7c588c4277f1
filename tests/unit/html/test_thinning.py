import numpy as np

from dr_lab.html.thinning import thinned


def test_a_short_curve_stays_as_it_is() -> None:
    time, value = np.arange(5.0), np.array([1.0, np.nan, 3.0, 2.0, 0.0])
    found = thinned(time, value, 5)
    np.testing.assert_array_equal(found, (time, value))


def test_what_stands_out_stays() -> None:
    time = np.linspace(0.0, 1.0, 100_003)
    value = np.sin(2 * np.pi * time)
    value[54_321], value[77_777] = 9.0, -9.0
    t, v = thinned(time, value, 1000)
    assert len(t) <= 1000
    assert (np.diff(t) > 0).all()
    assert set(time[[54_321, 77_777]]) <= set(t.tolist())
    assert (v.max(), v.min()) == (9.0, -9.0)
    np.testing.assert_array_equal(v, value[np.searchsorted(time, t)])  # points of the curve, none made up


def test_every_stretch_keeps_its_extremes() -> None:
    value = np.random.default_rng(0).normal(size=1000)
    _, v = thinned(np.arange(1000.0), value, 100)
    stretches = value.reshape(50, 20)
    assert set(v.tolist()) == set(np.concatenate([stretches.min(1), stretches.max(1)]).tolist())


def test_a_gap_stays_a_gap() -> None:
    value = np.ones(10_000)
    value[4_321] = np.nan
    time, thin = thinned(np.arange(10_000.0), value, 200)
    assert time[np.isnan(thin)].tolist() == [4321.0]
    assert np.isnan(thinned(np.arange(900.0), np.full(900, np.nan), 10)[1]).all()
