"""The papers' search by Ray Tune and hyperopt."""
