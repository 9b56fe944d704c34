"""The clips that are shipped with the tests are the shared ones."""

import numpy as np
import pytest
from pxr import Sdf
from real_files import CLIPS, SHARED, SHIPPED, needs_shared


def contents(path):
    """Every specification of a layer and its fields."""
    layer = Sdf.Layer.FindOrOpen(str(path))
    found = {}

    def visit(where):
        spec = layer.GetObjectAtPath(where)
        keys = spec.ListInfoKeys() if spec else []
        found[str(where)] = {key: spec.GetInfo(key) for key in keys if key != "timeSamples"}
        found[str(where)] |= {code: layer.QueryTimeSample(where, code) for code in layer.ListTimeSamplesForPath(where)}

    layer.Traverse(Sdf.Path.absoluteRootPath, visit)
    return found


@needs_shared
@pytest.mark.parametrize("path", sorted(SHIPPED.glob("*.usdc")), ids=lambda path: path.stem)
def test_shipped_clips_are_the_shared_ones(path):
    name = f"clips/{path.stem}.usda"
    assert name in CLIPS
    shipped, shared = contents(path), contents(SHARED / name)
    assert list(shipped) == list(shared)
    for where, fields in shared.items():
        assert fields.keys() == shipped[where].keys()
        for key, value in fields.items():
            np.testing.assert_array_equal(np.array(value), np.array(shipped[where][key]), err_msg=f"{where} {key}")


def test_two_clips_are_shipped():
    assert [path.name for path in sorted(SHIPPED.glob("*.usdc"))] == ["punching.usdc", "sitting.usdc"]
