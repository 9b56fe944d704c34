"""The Geomstats face: metrics and manifolds of poses."""
