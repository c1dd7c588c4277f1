"""Estimated noise against noise that was put in."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from dr_lab.errors import DataError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.lattice import lattice_step, on_lattice
from dr_lab.measurements.noise import estimate_noise
from dr_lab.trajectory import Array, Signal

COUNT = 2 * np.pi / 2048  # rad, an encoder's step
ROUNDING = COUNT / np.sqrt(12)


def pendulum(amplitude: float, rate: float = 500.0, jitter: float = 0.0, damping: float = 0.2) -> tuple[Array, Array]:
    """Time and angle of a damped pendulum of 1.2 Hz over 6 s; jitter in sample periods."""
    rng = np.random.default_rng(7)
    time = np.linspace(0.0, 6.0, int(6 * rate), endpoint=False)
    time = np.sort(time + rng.uniform(0, jitter, len(time)) / rate)

    def law(_: float, y: Array) -> list[float]:
        return [y[1], -60 * np.sin(y[0]) - damping * y[1]]

    solved = solve_ivp(law, (0.0, time[-1] + 1e-9), [amplitude, 0.0], t_eval=time, rtol=1e-10, atol=1e-12)
    return time, solved.y[0]


def estimate(time: Array, *values: Array, contract: DataContract) -> float:
    noise = estimate_noise([Signal("q", "rad", time, value) for value in values], 0.05, contract)
    assert (noise.unit, noise.source) == ("rad", "estimated")
    return noise.std


@pytest.mark.parametrize("std", [1e-2, 2e-3, 1e-4])
@pytest.mark.parametrize("jitter", [0.0, 0.3])
@pytest.mark.parametrize("amplitude", [0.3, 2.5])
def test_white_noise_within_ten_percent(contract: DataContract, amplitude: float, jitter: float, std: float) -> None:
    time, angle = pendulum(amplitude, jitter=jitter)
    noisy = angle + std * np.random.default_rng(0).normal(size=len(time))
    assert estimate(time, noisy, contract=contract) == pytest.approx(std, rel=0.1)


@pytest.mark.parametrize("rate", [100.0, 500.0, 1000.0])
@pytest.mark.parametrize("amplitude", [0.05, 0.3, 1.0, 2.5])
def test_encoder_of_2048_counts_within_ten_percent(contract: DataContract, amplitude: float, rate: float) -> None:
    time, angle = pendulum(amplitude, rate)
    assert estimate(time, COUNT * np.round(angle / COUNT), contract=contract) == pytest.approx(ROUNDING, rel=0.1)


def test_noise_on_top_of_an_encoder_is_seen(contract: DataContract) -> None:
    time, angle = pendulum(2.5)
    std = 3e-3
    noisy = COUNT * np.round((angle + std * np.random.default_rng(0).normal(size=len(time))) / COUNT)
    assert estimate(time, noisy, contract=contract) == pytest.approx(np.hypot(std, ROUNDING), rel=0.1)


def test_noise_of_more_than_a_step_counts_where_the_signal_is_slow_too(contract: DataContract) -> None:
    time, angle = pendulum(2.5, rate=100.0, damping=0.5)
    std = np.where(time < 2.5, 1.8e-2, 1.2e-2)  # a worn wiper rattles most while it moves fast
    noisy = COUNT * np.round((angle + std * np.random.default_rng(0).normal(size=len(time))) / COUNT)
    overall = np.hypot(np.sqrt(np.mean(std**2)), ROUNDING)
    assert estimate(time, noisy, contract=contract) == pytest.approx(overall, rel=0.15)


DEGREE = np.deg2rad(1.0)


def wheel(time: Array) -> Array:
    """Angle in rad of a gear motor's wheel that starts after half a second and goes on at 2300 degrees a second."""
    driven = np.maximum(time - 0.5, 0.0)
    return 40.0 * (driven - 0.15 * (1.0 - np.exp(-driven / 0.15)))


@pytest.mark.parametrize("rate", [100.0, 200.0, 500.0])
def test_a_log_of_uniform_motion_does_not_coarsen_an_encoder(contract: DataContract, rate: float) -> None:
    time = np.arange(0.0, 2.1, 1.0 / rate)
    counted = DEGREE * np.round(wheel(time) / DEGREE)
    parts = [Signal("q", "rad", time[part], counted[part]) for part in (time <= 1.05, time > 1.05)]
    assert estimate_noise(parts, 0.05, contract).std == pytest.approx(DEGREE / np.sqrt(12), rel=0.1)


@pytest.mark.parametrize("rate", [50.0, 200.0, 1000.0])
@pytest.mark.parametrize("std", [5e-3, 5e-4])
def test_white_noise_on_a_uniform_motion(contract: DataContract, rate: float, std: float) -> None:
    time = np.arange(0.0, 8.0, 1.0 / rate)
    noisy = 20.0 * time + 0.1 * np.sin(3.0 * time) + std * np.random.default_rng(0).normal(size=len(time))
    assert estimate(time, noisy, contract=contract) == pytest.approx(std, rel=0.1)


@pytest.mark.parametrize("rate", [200.0, 1000.0])
@pytest.mark.parametrize("std", [5e-3, 5e-4])
def test_bounces_do_not_raise_it(contract: DataContract, rate: float, std: float) -> None:
    time = np.arange(0.0, 8.0, 1.0 / rate)
    noisy = np.abs(np.sin(2.5 * time)) + std * np.random.default_rng(0).normal(size=len(time))
    assert estimate(time, noisy, contract=contract) == pytest.approx(std, rel=0.1)


def test_glitches_do_not_raise_it(contract: DataContract) -> None:
    rng = np.random.default_rng(0)
    time, angle = pendulum(1.0)
    noisy = angle + 2e-3 * rng.normal(size=len(time))
    noisy[rng.choice(len(time), 30, replace=False)] += 0.5
    assert estimate(time, noisy, contract=contract) == pytest.approx(2e-3, rel=0.1)


def test_logs_are_pooled_and_gaps_not_bridged(contract: DataContract) -> None:
    rng = np.random.default_rng(0)
    time, angle = pendulum(1.0)
    late = np.where(time > 3.0, time + 40.0, time)
    values = [angle + std * rng.normal(size=len(time)) for std in (1e-3, 1e-3, 1e-3)]
    assert estimate(late, *values, contract=contract) == pytest.approx(1e-3, rel=0.05)


def test_a_sensor_slower_than_its_topic_is_judged_by_its_new_values(contract: DataContract) -> None:
    time, angle = pendulum(1.0, rate=100.0)
    slow = angle + 1e-3 * np.random.default_rng(0).normal(size=len(time))
    fast_time = (time[:, None] + np.arange(5) * 0.002).ravel()
    assert estimate(fast_time, np.repeat(slow, 5), contract=contract) == pytest.approx(1e-3, rel=0.15)


def test_vector_channels_count_all_components(contract: DataContract) -> None:
    time, angle = pendulum(1.0)
    vector = np.stack([angle, 2 * angle, angle**2], axis=1) + 1e-3 * np.random.default_rng(0).normal(
        size=(len(time), 3)
    )
    assert estimate(time, vector, contract=contract) == pytest.approx(1e-3, rel=0.1)


def test_a_channel_that_never_changes_asks_for_noise_std(contract: DataContract) -> None:
    with pytest.raises(DataError, match=r"'q' never changes.*give noise_std"):
        estimate(np.arange(100.0), np.ones(100), contract=contract)


def test_short_logs_of_an_encoder_share_their_step(contract: DataContract) -> None:
    """Servos at 10 Hz went through few counts in a log, too few to tell a step, which another log of theirs tells."""
    time = 0.1 * np.arange(100, dtype=np.float64)
    many = COUNT * np.cumsum(np.arange(100) % 3).astype(np.float64)
    counts = ([0, 90, 210, 330, 430, 520, 606, 690, 771, 850], [4, 95, 217, 329, 436, 528, 610, 689, 772, 853])
    few = [COUNT * np.append(each, np.full(90, each[-1])).astype(np.float64) for each in counts]
    assert [lattice_step(each) for each in few] == [None, None]
    assert all(on_lattice(each, COUNT) for each in few)
    assert not on_lattice(np.random.default_rng(0).normal(size=20), COUNT)
    assert estimate(time, *few, many, contract=contract) >= 0.99 * ROUNDING


def test_logs_in_which_an_encoder_stands_still_say_nothing_of_its_step(contract: DataContract) -> None:
    time, angle = pendulum(1.0)
    moving, still = COUNT * np.round(angle / COUNT), np.full(len(time), 7 * COUNT)
    assert estimate(time, moving, still, still, contract=contract) == pytest.approx(ROUNDING, rel=0.1)


@pytest.mark.parametrize("digits", [None, 7])
def test_lattice_step_of_a_moving_encoder(digits: int | None) -> None:
    _, angle = pendulum(1.0)
    quantised = COUNT * np.round(angle / COUNT) + 0.123
    written = quantised if digits is None else np.round(quantised, digits)
    assert lattice_step(written) == pytest.approx(COUNT, rel=1e-5)


def test_lattice_step_of_decimals_and_of_sparse_visits() -> None:
    rng = np.random.default_rng(0)
    assert lattice_step(np.round(rng.normal(size=2000), 3)) == pytest.approx(1e-3)
    assert lattice_step(5e-8 * rng.integers(0, 5_000_000, 20_000).astype(np.float64)) == pytest.approx(5e-8)
    assert lattice_step(np.array([0.0, 5.0, 0.0, 5.0])) == pytest.approx(5.0)


@pytest.mark.parametrize("seed", range(20))
def test_continuous_and_constant_values_have_no_step(seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert lattice_step(rng.normal(size=rng.integers(20, 3000))) is None
    assert lattice_step(np.full(10, 3.0)) is None


def test_the_way_of_a_uniform_motion_is_no_step() -> None:
    wave = np.arange(200).astype(np.float64)
    assert lattice_step(11.43 * wave + 3.0) is None
    assert lattice_step(np.append(np.zeros(100), 11.43 * wave)) is None
    assert lattice_step(np.round(11.43 * wave)) == pytest.approx(1.0)
    assert lattice_step(np.round(0.43 * wave)) == pytest.approx(1.0)


@pytest.mark.parametrize("counts", [0.9, 0.93, 0.97, 0.99, 1.01, 1.05])
def test_an_encoder_that_moves_by_nearly_a_count_a_sample_is_rounded_all_the_same(
    contract: DataContract, counts: float
) -> None:
    sample = np.arange(2000, dtype=np.float64)
    way = counts * np.abs((sample + 0.3) % 1000 - 500.0)  # to and fro
    time = np.asarray(0.005 * sample, np.float64)
    found = estimate(time, COUNT * np.round(way), contract=contract)
    assert found == pytest.approx(ROUNDING, rel=0.1)


def test_a_servo_that_jumps_and_rests_is_known_no_better_than_its_counts(contract: DataContract) -> None:
    """At uneven times the polynomials of its rest leave a rounding error, which is no noise."""
    random = np.random.default_rng(1)
    time = np.cumsum(random.uniform(0.098, 0.104, 600))
    goal, way = np.repeat(random.uniform(-200.0, 200.0, 10), 60), np.zeros(600)
    for k in range(1, 600):
        way[k] = way[k - 1] + np.clip(goal[k] - way[k - 1], -152.0, 152.0)
    noise = estimate_noise([Signal("q", "rad", time, COUNT * np.round(way))], 0.3, contract)
    assert noise.std >= 0.99 * ROUNDING
