"""Curves through poses: every scheme, the registry and `interpolate`."""
