"""What is on a stage, so that two can be told apart; and the errors that OpenUSD's validators find on one."""

import contextlib
import io
from functools import cache

from pxr import Sdf, Tf, Usd, UsdGeom, UsdSkel, UsdValidation
from rigs import make_rig, random_rotations, set_samples

SCHEMA = "GeodesicMetricAPI"
OURS = ("geodesicMetric:", "userProperties:geodesicMetric")
CHANNELS = ("rotations", "translations", "scales", "blendShapeWeights")


def differences(source, out, written=CHANNELS):
    """Names of what is different on the stage of another file, but for what a tool of ours writes there.

    Parameters
    ----------
    source, out : path
    written : names of attributes of animations that may differ
    """
    before, after = (_everything(Usd.Stage.Open(str(path)), written) for path in (source, out))
    return sorted(name for name in {*before, *after} if before.get(name) != after.get(name))


def _everything(stage, written):
    found = {f"stage {key}": stage.GetMetadata(key) for key in ("upAxis", "metersPerUnit", "defaultPrim")}
    found["stage timeCodesPerSecond"] = stage.GetTimeCodesPerSecond()
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)):
        path, metadata = str(prim.GetPath()), prim.GetAllAuthoredMetadata()
        metadata.get("customData", {}).pop("geodesicMetric", None)
        if not metadata.get("customData"):
            metadata.pop("customData", None)
        metadata.pop("apiSchemas", None)
        applied = [name for name in prim.GetAppliedSchemas() if name != SCHEMA]
        found[path] = [*sorted((key, str(value)) for key, value in metadata.items()), applied]
        skipped = written if prim.IsA(UsdSkel.Animation) else ()
        for name in prim.GetAuthoredPropertyNames():
            if name not in skipped and not name.startswith(OURS):
                found[f"{path}.{name}"] = _value(prim.GetProperty(name))
    return found


def _value(prop):
    if isinstance(prop, Usd.Relationship):
        return prop.GetTargets()
    samples = [(code, repr(prop.Get(code))) for code in prop.GetTimeSamples()]
    default = prop.Get()
    if isinstance(default, Sdf.AssetPath):
        default = default.resolvedPath or default.path
    return str(prop.GetTypeName()), repr(default), samples, prop.GetConnections()


@cache
def _validator():
    return UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())


def errors_of(path):
    """Names of the errors of a file; places differ between a source and its override."""
    held = Sdf.Layer.Find(str(path))
    if held and not held.dirty:
        held.Reload()  # OpenUSD may still hold what the file was before
    with contextlib.redirect_stderr(io.StringIO()):
        return {
            (error.GetName(), str(error.GetValidator().GetMetadata().name))
            for error in _validator().Validate(Usd.Stage.Open(str(path)))
            if error.GetType() == UsdValidation.ValidationErrorType.Error
        }


def new_errors(inputs, now=False):
    """Make what tells the errors of a file that none of the inputs has; `now` if the inputs are going to change."""

    @cache
    def known():
        with contextlib.suppress(Tf.ErrorException):  # the command will refuse what cannot be opened
            return set().union(*map(errors_of, inputs))
        return set()

    if now:
        known()

    def new(path):
        found = errors_of(path)
        return found - known() if found else found

    return new


def make_shot(folder):
    """Assets in a folder of their own; a weaker layer with an offset; variants; a payload; a texture."""
    assets = folder / "assets"
    assets.mkdir(parents=True)
    (assets / "skin.png").write_bytes(b"png")
    stage = make_rig(assets / "hero.usda", codes=range(8), rotations=random_rotations(8, 3), rate=30)
    stage.GetPrimAtPath("/Rig").CreateAttribute("map", Sdf.ValueTypeNames.Asset).Set("./skin.png")
    stage.Save()
    prop = Usd.Stage.CreateNew(str(assets / "prop.usdc"))
    UsdGeom.Cube.Define(prop, "/Prop").CreateSizeAttr().Set(2.0, 5.0)
    prop.SetDefaultPrim(prop.GetPrimAtPath("/Prop"))
    prop.Save()
    weak = Usd.Stage.CreateNew(str(folder / "layout.usda"))
    weak.SetTimeCodesPerSecond(30)
    weak.DefinePrim("/Shot/Hero").GetReferences().AddReference("./assets/hero.usda", "/Rig")
    weak.DefinePrim("/Shot/Prop").GetPayloads().AddPayload("./assets/prop.usdc")
    hero = weak.GetPrimAtPath("/Shot/Hero")
    variants = hero.GetVariantSets().AddVariantSet("take")
    for seed, take in enumerate(("one", "two")):
        variants.AddVariant(take)
        variants.SetVariantSelection(take)
        with variants.GetVariantEditContext():
            set_samples(weak, "rotations", range(8), random_rotations(8, 3, seed + 7), "/Shot/Hero/Anim")
    weak.Save()
    shot = Usd.Stage.CreateNew(str(folder / "shot.usda"))
    shot.SetMetadata("comment", "shot 1")
    shot.SetTimeCodesPerSecond(24)
    shot.SetStartTimeCode(1)
    shot.SetEndTimeCode(9)
    UsdGeom.SetStageUpAxis(shot, "Z")
    shot.GetRootLayer().subLayerPaths.append("./layout.usda")
    shot.SetDefaultPrim(shot.OverridePrim("/Shot"))
    shot.Save()
    return folder / "shot.usda"
