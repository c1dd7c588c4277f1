from dataclasses import replace

import numpy as np
import pytest
from effect_machines import block, catalogue_effect, hanging, placed, scales_of

from dr_lab.effects.effect import place
from dr_lab.effects.encoder_eccentricity import EncoderEccentricity
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
    z = np.array([[RATIO * np.cos(DIRECTION), RATIO * np.sin(DIRECTION), 1.0]])
    read = model.reading(z, "hinge.position", turning, START)
    np.testing.assert_allclose(read(time)[0, 0, :, 0], exact, atol=RATIO**2)
    assert np.abs(exact - angle).max() == pytest.approx(RATIO, rel=0.01)


def test_each_context_has_its_own() -> None:
    model = hanging().with_effect(placed(hanging(), "encoder_eccentricity", "hinge"))
    z, time = np.array([[0.0, 0.0, 1.0], [0.1, 0.0, 1.0], [0.0, -0.05, 3.0]]), np.full((1, 1, 1), 0.05)
    seen = model.reading(z, "hinge.position", turning, START)(time)[:, 0, 0, 0]
    np.testing.assert_allclose(seen, [1.0, 1.0 + 0.1 * np.sin(1.0), 1.0 - 0.05 * np.cos(3.0) / 3.0])
    assert model.reading(z, "hinge.velocity", turning, START) is turning


def test_a_reading_tells_one_position_at_all_that_the_bounds_allow() -> None:
    model = hanging().with_effect(placed(hanging(), "encoder_eccentricity", "hinge"))
    ends = np.stack([model.space.low, model.space.high])[:, -3:]
    z = np.array([[a, b, n] for a in ends[:, 0] for b in ends[:, 1] for n in ends[:, 2]])
    time = np.linspace(0.0, 0.4, 20_000)[None, None]
    assert (np.diff(model.reading(z, "hinge.position", turning, START)(time)[:, 0, :, 0]) > 0).all()


def test_its_bounds_stay_where_a_reading_tells_one_position() -> None:
    effect = placed(hanging(), "encoder_eccentricity", "hinge").effect
    assert effect.limit("sine", kept=0.3, margin=0.02) == effect.limit("cosine", kept=0.3, margin=0.02) == 0.0


def test_a_slides_error_repeats_with_the_lead_of_its_screw() -> None:
    found = catalogue_effect("encoder_eccentricity")
    assert isinstance(found, EncoderEccentricity)
    effect = replace(found, periods=2 * np.pi / 0.005)
    model = block().with_effect(place(effect, block().nominal(), "rail", scales_of(block())))
    assert [p.unit for p in model.effects[-1].parameters] == ["rad", "rad"]
    screw = 2 * np.pi * 1e-4 / 0.005  # rad of the screw
    read = model.reading(np.array([[screw, 0.0]]), "rail.position", lambda time: (0.5 * time)[..., None], START)
    seen = read(np.array([[[0.0, 0.0025, 0.005, 0.01]]]))[0, 0, :, 0]
    np.testing.assert_allclose(seen, [0.0, 0.00125 + 1e-4, 0.0025, 0.005], atol=1e-9)


def test_a_disc_at_the_joint_is_looked_for_however_little_it_turns() -> None:
    short = placed(hanging(), "encoder_eccentricity", "hinge", scales_of(hanging(), position=0.01))
    assert [p.low for p in short.parameters][-1] == 1.0
