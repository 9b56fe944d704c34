"""Data in a page's script cannot end the script, whatever names a file holds."""

import json

from usd_tools.player.scripts import read_scripts, script_json


def test_names_cannot_end_the_script():
    names = ["</script><script>alert(1)</script>", "<!--<script>", "a < b"]
    data = {"clips": [{"frames": [0, 1], "name": name} for name in names]}
    text = script_json(data)
    assert "<" not in text
    assert json.loads(text) == data


def test_scripts_may_stand_in_a_page():
    scripts = read_scripts()
    assert len(scripts) == 2
    assert not [script for script in scripts if "</script" in script or "http" in script]
