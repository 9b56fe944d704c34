"""Residuals off the geodesic-spline, learned from a library of clips of one rig."""
