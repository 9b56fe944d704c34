"""Skeletal animation in USD: found, read, resampled, written."""
