"""The schema is what usdGenSchema makes of its source, says what is written, and is applied beside others."""

import subprocess
import sys

import numpy as np
import pytest
from pxr import Sdf, Usd
from rigs import ANIMATION, JOINTS, make_rig, some_metric

from geomstats_anim.names import INVARIANCES, SCHEME_NAMES
from usd_tools.metrics.attributes import read_metric, write_metric
from usd_tools.metrics.schema import SCHEMA, SCHEMA_FOLDER, apply_schema, register_schema


@pytest.fixture(scope="module")
def definition():
    register_schema()
    return Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(SCHEMA)


@pytest.mark.slow
def test_it_is_generated_from_its_source(tmp_path):
    generate = [sys.executable, "-m", "pxr.Usd.usdGenSchema", str(SCHEMA_FOLDER / "schema.usda"), str(tmp_path)]
    done = subprocess.run(generate, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for name in ("generatedSchema.usda", "plugInfo.json"):
        text = (tmp_path / name).read_text().replace("@PLUG_INFO_LIBRARY_PATH@", "")
        for placeholder in ("@PLUG_INFO_RESOURCE_PATH@", "@PLUG_INFO_ROOT@"):
            text = text.replace(placeholder, ".")
        assert [line.rstrip() for line in text.splitlines()] == (SCHEMA_FOLDER / name).read_text().splitlines()


def test_it_says_what_is_written(definition):
    stage = Usd.Stage.CreateInMemory()
    spec = Sdf.PrimSpec(stage.GetRootLayer(), "Anim", Sdf.SpecifierDef, "SkelAnimation")
    write_metric(spec, some_metric(axes=True))
    written = {attribute.name: attribute.typeName for attribute in spec.attributes}
    schema = {name: definition.GetAttributeDefinition(name).GetTypeName() for name in definition.GetPropertyNames()}
    assert written == schema
    assert not any(attribute.custom for attribute in spec.attributes)
    assert all(definition.GetPropertyDocumentation(name) for name in definition.GetPropertyNames())


def test_allowed_words_are_those_of_the_program(definition):
    words = {
        name: list(definition.GetAttributeDefinition(f"geodesicMetric:{name}").GetMetadata("allowedTokens"))
        for name in ("scheme", "invariance")
    }
    assert words == {"scheme": list(SCHEME_NAMES), "invariance": list(INVARIANCES)}


def test_it_gives_no_values(definition):
    """A prim with the schema and nothing else has no metric."""
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/Anim", "SkelAnimation")
    apply_schema(stage.GetRootLayer().GetPrimAtPath("/Anim"))
    assert prim.HasAPI(SCHEMA) and prim.HasAttribute("geodesicMetric:alpha")
    assert read_metric(prim) is None


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (Sdf.TokenListOp(), [SCHEMA]),
        (Sdf.TokenListOp.Create(prependedItems=["OtherAPI"]), ["OtherAPI", SCHEMA]),
        (Sdf.TokenListOp.CreateExplicit(["OtherAPI"]), ["OtherAPI", SCHEMA]),
        (Sdf.TokenListOp.Create(appendedItems=[SCHEMA]), [SCHEMA]),
        (Sdf.TokenListOp.Create(deletedItems=[SCHEMA]), [SCHEMA]),
    ],
)
def test_it_is_applied_once_beside_others(before, after):
    layer = Sdf.Layer.CreateAnonymous()
    spec = Sdf.PrimSpec(layer, "Anim", Sdf.SpecifierDef, "SkelAnimation")
    spec.SetInfo("apiSchemas", before)
    for _ in range(2):
        apply_schema(spec)
        assert spec.GetInfo("apiSchemas").ApplyOperations([]) == after


def test_a_verb_applies_it_over_the_source(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    assert run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)[0] == 0
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    assert stage.GetPrimAtPath(ANIMATION).HasAPI(SCHEMA)


def test_files_without_it_keep_working(tmp_path):
    stage = make_rig(tmp_path / "in.usda")
    spec = stage.GetRootLayer().GetPrimAtPath(ANIMATION)
    write_metric(spec, some_metric(axes=True))
    spec.ClearInfo("apiSchemas")
    for attribute in spec.attributes:
        attribute.custom = True
    metric = read_metric(stage.GetPrimAtPath(ANIMATION))
    np.testing.assert_array_equal(metric.parameters.axes, some_metric(axes=True).parameters.axes)
    assert metric.joints == tuple(JOINTS)
