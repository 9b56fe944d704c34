"""Geodesics of many segments at once, and which of them are the shortest."""
