"""Metrics and manifolds of poses for Geomstats."""
