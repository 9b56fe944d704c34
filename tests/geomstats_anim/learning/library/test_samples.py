from geomstats_anim.learning.library.samples import GAPS


def test_the_double_of_every_length_is_learned_or_longer_than_all():
    assert all(2 * gap in GAPS or 2 * gap > GAPS[-1] for gap in GAPS)
