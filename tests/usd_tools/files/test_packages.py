"""Packages of packages, textures and names beyond ASCII; and the same bytes from one process to the next."""

import subprocess
import sys
import zipfile

import pytest
from composed import make_shot
from pxr import Sdf, Usd, UsdUtils
from rigs import make_rig, random_rotations, read

VERBS = {"upsample": ["--factor", 2], "downsample": ["--rate", 0.6, "--scheme", "slerp"], "learn": ["--rate", 0.5]}


def textured(folder, texture="skin.png"):
    """A rig with a texture in a folder of its own."""
    (folder / "tex").mkdir(parents=True)
    (folder / "tex" / texture).write_bytes(b"png")
    stage = make_rig(folder / "in.usda", codes=range(8), rotations=random_rotations(8, 3))
    stage.GetPrimAtPath("/Rig").CreateAttribute("map", Sdf.ValueTypeNames.Asset).Set(f"./tex/{texture}")
    stage.Save()
    return folder / "in.usda"


def check_package(path, texture="skin.png"):
    """Everything is found, in the package itself."""
    stage = Usd.Stage.Open(str(path))
    asset = stage.GetPrimAtPath("/Rig").GetAttribute("map").Get()
    assert asset.resolvedPath.startswith(f"{path}[") and asset.resolvedPath.endswith(f"/{texture}]")
    layers, assets, missing = UsdUtils.ComputeAllDependencies(str(path))
    assert missing == [] and assets == [asset.resolvedPath]
    assert all(layer.realPath.startswith(str(path)) for layer in layers)
    assert stage.GetCompositionErrors() == []
    with zipfile.ZipFile(path) as archive:
        assert not any(name.endswith(".usdz") for name in archive.namelist())


@pytest.mark.parametrize("flat", [[], ["--flatten"]])
@pytest.mark.parametrize("first", VERBS)
def test_packages_are_packed_again_and_again(tmp_path, run, first, flat):
    path = textured(tmp_path / "show")
    for turn, verb in enumerate((first, "upsample", "learn", "upsample", "downsample")):
        out = tmp_path / f"{turn}.usdz"
        code, _, err = run(verb, path, "-o", out, *VERBS[verb], *(flat if turn == 3 else []))
        assert (code, err) == (0, "")
        check_package(out)
        path = out


@pytest.mark.parametrize("first", ["downsample", "upsample"])
def test_names_beyond_ascii_are_packed_again(tmp_path, run, first):
    source = textured(tmp_path / "ä", "tö.png")
    for verb, path, name in ((first, source, "ü.usdz"), ("upsample", tmp_path / "ü.usdz", "x.usdz")):
        code, _, err = run(verb, path, "-o", tmp_path / name, *VERBS[verb])
        assert (code, err) == (0, "")
        check_package(tmp_path / name, "tö.png")


def test_names_of_another_encoding_are_refused(tmp_path, run, refuse):
    run("upsample", textured(tmp_path / "show"), "-o", tmp_path / "a.usdz", "--factor", 2)
    with zipfile.ZipFile(tmp_path / "a.usdz", "a") as archive:
        archive.writestr("t__.txt", "")
    (tmp_path / "b.usdz").write_bytes((tmp_path / "a.usdz").read_bytes().replace(b"t__.txt", b"t\xe4\xf6.txt"))
    sentence = refuse("upsample", tmp_path / "b.usdz", "-o", tmp_path / "c.usdz", "--factor", 2)
    assert sentence == "b.usdz has names that are not UTF-8; pack it again."


def test_missing_textures_are_named(tmp_path, run, monkeypatch):
    source = textured(tmp_path / "show")
    (tmp_path / "show" / "tex" / "skin.png").unlink()
    monkeypatch.chdir(tmp_path)
    code, _, err = run("upsample", source, "-o", "out.usdz", "--factor", 2)
    assert code == 1
    assert err.endswith("error: out.usdz cannot be packed, since it references files that cannot be found: skin.png.\n")
    assert "/out.usdz'" in err and ".out.usdz." not in err  # no temporary folder
    assert not (tmp_path / "out.usdz").exists()


@pytest.mark.parametrize(
    "name", [*(pytest.param(name, marks=pytest.mark.slow) for name in ("out.usdc", "flat.usdc")), "out.usdz"]
)
@pytest.mark.parametrize("verb", ["upsample", pytest.param("learn", marks=pytest.mark.slow)])
def test_two_processes_write_the_same_bytes(tmp_path, verb, name):
    """Addresses in memory, and what goes by them, are different in each process."""
    source, contents = make_shot(tmp_path / "show"), []
    options = [*map(str, VERBS[verb]), *(["--flatten"] if name.startswith("flat") else [])]
    for turn in range(2):
        out = tmp_path / str(turn) / name
        out.parent.mkdir()
        command = [sys.executable, "-m", f"usd_tools.{verb}", source, "-o", out, *options]
        subprocess.run(command, check=True, capture_output=True)
        contents.append(out.read_bytes())
    assert len(set(contents)) == 1
    assert len(read(out, prim="/Shot/Hero/Anim")[0]) == {"upsample": 15, "learn": 8}[verb]
