"""Metrics in USD, and what they mean to an artist."""
