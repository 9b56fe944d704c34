"""Data in the page's script cannot end the script, whatever names a file holds."""

import json

from usd_tools.comparison.report import page


def test_names_cannot_end_the_script():
    names = ["</script><script>alert(1)</script>", "<!--<script>", "a < b"]
    data = {"clips": [{"frames": [0, 1], "name": name} for name in names]}
    text = page._json(data)
    assert "<" not in text
    assert json.loads(text) == data
