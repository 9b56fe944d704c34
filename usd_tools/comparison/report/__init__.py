"""The report of a comparison: figures, and a page that needs no network."""
