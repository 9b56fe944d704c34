"""Stored metrics are checked: lengths, types, names, words; by ourselves, by UsdValidation, and by inspect."""

from dataclasses import replace

import pytest
from pxr import UsdValidation
from rigs import ANIMATION, JOINTS, make_rig, some_metric

from geomstats_anim.names import SCHEME_NAMES
from usd_tools.metrics.attributes import write_metric
from usd_tools.metrics.validation import VALIDATOR, register_validator, validate_metric


@pytest.fixture
def prim(tmp_path):
    stage = make_rig(tmp_path / "in.usda")
    write_metric(stage.GetRootLayer().GetPrimAtPath(ANIMATION), some_metric(axes=True))
    yield stage.GetPrimAtPath(ANIMATION)
    del stage


def set_value(prim, name, value):
    attribute = prim.GetAttribute(f"geodesicMetric:{name}")
    attribute.Clear() if value is None else attribute.Set(value)


def test_nothing_is_wrong_with_a_metric_that_fits_and_with_none(prim):
    assert validate_metric(prim) == []
    for name in [name for name in prim.GetPropertyNames() if name.startswith("geodesicMetric:")]:
        prim.RemoveProperty(name)
    assert validate_metric(prim) == []


@pytest.mark.parametrize(
    ("values", "problems"),
    [
        ({"alpha": [1.0]}, ["geodesicMetric:alpha has 1 values for 3 joints."]),
        (
            {"alpha": [1.0], "beta": None, "axes": [(0, 0, 0)] * 2, "version": 7},
            [
                "geodesicMetric:version is 7, but this program reads 1; update it.",
                "geodesicMetric:alpha has 1 values for 3 joints.",
                "geodesicMetric:beta is missing; write the whole metric, or remove it.",
                "geodesicMetric:axes has 2 values for 3 joints.",
            ],
        ),
        (
            {"tension": [3.0, 0.0, 0.0]},
            ["the stored metric is invalid: tension of joint 0 is 3.0; it must be from 0 to 2."],
        ),
        (
            {"scheme": "spline"},
            [f"geodesicMetric:scheme 'spline' does not exist; use {', '.join(SCHEME_NAMES)}."],
        ),
        (
            {"joints": [*JOINTS[:1], "x", "y"]},
            [
                "the animation has spine and 1 other joint, but the metric does not.",
                "the metric has x and 1 other joint, but the animation does not.",
            ],
        ),
    ],
)
def test_problems(prim, values, problems):
    for name, value in values.items():
        set_value(prim, name, value)
    assert validate_metric(prim) == [f"{ANIMATION}: {problem}" for problem in problems]


def test_usd_validation_finds_the_same(prim):
    if not register_validator():
        pytest.skip("this OpenUSD takes no validators from Python")
    validator = UsdValidation.ValidationRegistry().GetOrLoadValidatorByName(VALIDATOR)
    context = UsdValidation.ValidationContext([validator])
    assert context.Validate(prim.GetStage()) == []
    set_value(prim, "alpha", [1.0])
    set_value(prim, "beta", [1.0])
    errors = context.Validate(prim.GetStage())
    assert [error.GetMessage() for error in errors] == validate_metric(prim)
    assert errors[0].GetSites()[0].GetPrim() == prim


def test_inspect_warns(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda")
    write_metric(stage.GetRootLayer().GetPrimAtPath(ANIMATION), replace(some_metric(), joints=("hips", "x", "y")))
    stage.Save()
    code, _, err = run("inspect", tmp_path / "in.usda")
    assert code == 0 and err.splitlines() == [
        f"warning: {problem}" for problem in validate_metric(stage.GetPrimAtPath(ANIMATION))
    ]
