"""The usdview plug-in loads through OpenUSD's registry, and its commands leave all but the session alone."""

from pathlib import Path

import pytest
import usdview_stand_in
from pxr import Plug, Tf, Usd
from rigs import ANIMATION, SKELETON, bits, make_rig, read, some_metric
from usdview_stand_in import PluginRegistry, PluginUIBuilder, UsdviewApi

from usd_tools.metrics.attributes import write_metric
from usd_tools.upsample import UpsampleOptions, upsample

FOLDER = Path(__file__).resolve().parents[2] / "integrations" / "usdview"


@pytest.fixture(scope="module")
def plugin():
    """The plug-in, registered as usdview registers it."""
    usdview_stand_in.install()
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(FOLDER))
        Plug.Registry().RegisterPlugins(str(FOLDER / "geomstats_anim_usdview"))
        found = Plug.Registry().GetPluginWithName("geomstats_anim_usdview")
        assert found.Load()
        import geomstats_anim_usdview.commands

        yield geomstats_anim_usdview


@pytest.fixture
def api(tmp_path, plugin):
    stage = make_rig(tmp_path / "in.usda")
    return UsdviewApi(stage, stage.GetPrimAtPath(SKELETON))


def codes(stage, path=ANIMATION):
    return stage.GetPrimAtPath(path).GetAttribute("rotations").GetTimeSamples()


def test_the_registry_knows_the_menu(plugin):
    container = Tf.Type.FindByName("geomstats_anim_usdview.GeodesicContainer").pythonClass()
    registry, builder = PluginRegistry(), PluginUIBuilder()
    container.registerPlugins(registry, None)
    container.configureView(registry, builder)
    labels = {name: registry.commands[name][0] for name in builder.menus["Geodesic"]}
    assert list(labels.values()) == ["Upsample...", "Metric of Each Joint...", "Remove"]
    assert labels.keys() == registry.commands.keys()


def test_upsample_into_the_session_and_remove(tmp_path, plugin, api):
    result = plugin.commands.upsample(api, factor=2, scheme="geodesic", joint=("arm:alpha=4",))
    assert codes(api.stage) == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
    assert api.status == ["4 -> 7 samples, in the session layer."] and result.animations[0].scheme == "geodesic"
    assert not api.stage.GetRootLayer().dirty and api.stage.GetEditTarget().GetLayer() == api.stage.GetRootLayer()
    style = UpsampleOptions(factor=2, scheme="geodesic", joint="arm:alpha=4")
    upsample(tmp_path / "in.usda", tmp_path / "out.usda", style)
    api.stage.Flatten().Export(str(tmp_path / "seen.usda"))
    assert bits(read(tmp_path / "seen.usda")[1]) == bits(read(tmp_path / "out.usda")[1])
    plugin.commands.remove(api)
    assert api.status[-1] == "Removed." and codes(api.stage) == [0.0, 1.0, 2.0, 3.0]
    assert not api.stage.GetSessionLayer().subLayerPaths
    plugin.commands.remove(api)
    assert api.status[-1] == "There is nothing to remove for the selected animations."


def test_a_second_time_starts_from_the_source(plugin, api):
    plugin.commands.upsample(api, factor=3)
    plugin.commands.upsample(api, factor=2)
    assert codes(api.stage) == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
    assert len(api.stage.GetSessionLayer().subLayerPaths) == 1


def test_each_animation_has_its_own_result(tmp_path, plugin):
    for name in ("a", "b"):
        make_rig(tmp_path / f"{name}.usda")
    stage = Usd.Stage.CreateInMemory()
    prims = [stage.DefinePrim(f"/{name}") for name in ("a", "b")]
    for prim in prims:
        prim.GetReferences().AddReference(str(tmp_path / f"{prim.GetName()}.usda"))
    for prim in prims:
        plugin.commands.upsample(UsdviewApi(stage, prim), factor=2)
    plugin.commands.remove(UsdviewApi(stage, prims[0]))
    assert [len(codes(stage, f"/{name}/Anim")) for name in ("a", "b")] == [4, 7]
    plugin.commands.remove(UsdviewApi(stage, stage.GetPseudoRoot()))
    assert [len(codes(stage, f"/{name}/Anim")) for name in ("a", "b")] == [4, 4]


def test_what_is_refused_changes_nothing(plugin, api):
    plugin.commands.upsample(api, factor=2)
    before = list(api.stage.GetSessionLayer().subLayerPaths)
    for options in ({"factor": 2, "joint": ("leg:alpha=4",)}, {"factor": 0}, {"factor": 2, "scheme": "spline"}):
        assert plugin.commands.upsample(api, **options) is None
    assert "leg matches no joint" in api.status[1] and "--factor" in api.status[2] and "--scheme" in api.status[3]
    assert list(api.stage.GetSessionLayer().subLayerPaths) == before and len(codes(api.stage)) == 7
    nothing = UsdviewApi(Usd.Stage.CreateInMemory())
    assert plugin.commands.upsample(nothing, factor=2) is None and plugin.commands.metric_tables(nothing) == []
    plugin.commands.remove(nothing)
    assert all("has no skeletal animation" in line for line in nothing.status) and len(nothing.status) == 3


def test_tables_of_metrics(plugin, api):
    assert plugin.commands.metric_tables(api) == []
    assert api.status == ["No metric is stored with the selected animations."]
    write_metric(api.stage.GetRootLayer().GetPrimAtPath(ANIMATION), some_metric(axes=True))
    ((title, header, rows),) = plugin.commands.metric_tables(api)
    assert title.startswith(f"{ANIMATION}: geodesic, 3 joints") and len(header) == len(rows[0])
    assert [row[0] for row in rows] == ["hips", "spine", "arm"]
    api.stage.GetPrimAtPath(ANIMATION).GetAttribute("geodesicMetric:beta").Set([1.0])
    assert plugin.commands.metric_tables(api) == []
    assert api.status[-1] == f"{ANIMATION}: geodesicMetric:beta has 1 values for 3 joints."
