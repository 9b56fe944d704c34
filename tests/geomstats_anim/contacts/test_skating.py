"""Laws of how far planted points slide and float."""

from dataclasses import replace

import numpy as np
import pytest
from walker import walk

from geomstats_anim.contacts import find_contacts, skating

UP = np.array([0.0, 1.0, 0.0])


def moved(animation, velocity=(0.0, 0.0, 0.0), height=0.0):
    translations = np.array(animation.translations)
    translations[:, 0] += animation.times[:, None] * np.array(velocity)
    translations[:, 0, 1] += height
    return replace(animation, translations=translations)


def test_a_walk_does_not_skate_on_its_own_feet():
    original, _ = walk()
    found = find_contacts(original, UP)
    skate, floating = skating([original], [original], [found])
    assert skate < 2.0  # what is found at the ends of steps moves a little
    assert floating == 0.0


def test_it_is_the_speed_along_the_ground_and_the_height_above():
    original, planted = walk()
    found = find_contacts(original, UP)
    still = np.repeat(planted[1:] & planted[:-1], 2, axis=1)
    found = replace(found, planted=found.planted & still)
    skate, floating = skating([moved(original, (0.03, 0.5, 0.04), 0.0)], [original], [found])
    assert skate == pytest.approx(5.0, abs=1e-6)  # 3 and 4 centimetres per second; upwards does not count
    assert skating([moved(original, height=-0.02)], [original], [found]) == pytest.approx((0.0, 2.0), abs=1e-6)


def test_stretches_count_by_their_time():
    original, _ = walk()
    first, second = original.at_frames(slice(0, 121)), original.at_frames(slice(120, None))
    contacts = [find_contacts(original, UP)]
    whole = skating([moved(original, (0.1, 0.0, 0.0))], [original], contacts)
    cut = [
        replace(contacts[0], times=part.times, planted=contacts[0].planted[rows])
        for part, rows in ((first, slice(0, 120)), (second, slice(120, None)))
    ]
    parts = [moved(part, (0.1, 0.0, 0.0)) for part in (first, second)]
    assert skating(parts, [first, second], cut) == pytest.approx(whole)


def test_nothing_planted_is_nothing_to_measure():
    original, _ = walk()
    found = find_contacts(original, UP)
    assert skating([original], [original], [replace(found, planted=np.zeros_like(found.planted))]) is None
