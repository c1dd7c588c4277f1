import numpy as np
import pytest
from effect_machines import block, catalogue_effect, hanging, placed

from dr_lab.trajectory import Array

START = np.zeros((1, 1))
RATIO, DIRECTION = 0.02, 0.7  # e/r; where the centre lies, rad


def turning(time: Array) -> Array:
    return (20.0 * time)[..., None]


def test_reading_is_the_angle_seen_from_a_centre_beside_the_axis() -> None:
    """A disc turned by q about the axis, with its centre at e/r from it, passes a fixed reading head at radius 1."""
    time = np.linspace(0.0, 0.4, 50)[None, None]
    angle = 20.0 * time[0, 0]
    centre = RATIO * np.exp(1j * (angle + DIRECTION))  # fixed on the disc
    exact = angle + np.angle(1.0 / (1.0 - centre))  # the head's place on the disc, from the disc's own centre
    model = hanging().with_effect(placed(hanging(), "encoder_eccentricity", "hinge"))
    z = RATIO * np.array([[np.cos(DIRECTION), np.sin(DIRECTION)]])
    read = model.reading(z, "hinge.position", turning, START)
    np.testing.assert_allclose(read(time)[0, 0, :, 0], exact, atol=RATIO**2)
    assert np.abs(exact - angle).max() == pytest.approx(RATIO, rel=0.01)


def test_each_context_has_its_own() -> None:
    model = hanging().with_effect(placed(hanging(), "encoder_eccentricity", "hinge"))
    z, time = np.array([[0.0, 0.0], [0.1, 0.0], [0.0, -0.05]]), np.full((1, 1, 1), 0.05)
    seen = model.reading(z, "hinge.position", turning, START)(time)[:, 0, 0, 0]
    np.testing.assert_allclose(seen, [1.0, 1.0 + 0.1 * np.sin(1.0), 1.0 - 0.05 * np.cos(1.0)])
    assert model.reading(z, "hinge.velocity", turning, START) is turning


def test_sits_at_hinges_alone() -> None:
    effect = catalogue_effect("encoder_eccentricity")
    assert effect.sites(hanging().nominal()) == ("hinge",)
    assert effect.sites(block().nominal()) == ()
