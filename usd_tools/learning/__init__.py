"""Clips to learn from, and what learning brought."""
