"""Command lines: arguments, errors, progress, tables; no USD."""
