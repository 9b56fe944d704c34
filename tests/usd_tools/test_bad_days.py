"""Killed, crowded, out of room, not allowed: OUT is the old file or the whole new one, and the input stays."""

import os
import shutil
import signal
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pytest
from bvh_files import write_bvh
from pxr import Sdf, UsdUtils
from rigs import make_rig, random_rotations
from zygote import Zygote

NOBODY = 65534
OUTS = ["out.usda", "out.usdc", "out.usdz", "flat.usda"]
WAYS = [*OUTS, "in place", "learn", "downsample", "from_bvh", "report"]


@pytest.fixture(scope="module")
def zygote():
    process = Zygote()
    yield process
    process.stop()


@pytest.fixture
def folder():
    """A folder that other users may enter, which pytest's may not."""
    with tempfile.TemporaryDirectory() as name:
        os.chmod(name, 0o777)
        yield Path(name)


def make_clip(path, n_frames=200):
    make_rig(path, codes=range(n_frames), rotations=random_rotations(n_frames, 3))
    return path


def upsample(source, out, *options):
    flat = ["--flatten"] if out.name.startswith("flat") else []
    return ["upsample", source, "-o", out, "--factor", 2, *flat, *options]


def left(folder):
    return sorted(path.name for path in folder.iterdir())


def call_of(name, folder):
    """Input, output and command line of a way to write a file."""
    source, out = folder / "in.usda", folder / (name if name in OUTS else "out.usda")
    if name == "from_bvh":
        source = folder / "in.bvh"
        write_bvh(source, n_frames=300)
        return source, out, ["from_bvh", source, "-o", out]
    make_clip(source, 40 if name in ("learn", "downsample") else 200)
    if name == "in place":
        return source, source, ["upsample", source, "--in-place", "--factor", 2]
    if name == "report":
        out = folder / "out.json"
        return source, out, ["upsample", source, "--dry-run", "--factor", 2, "--report", out]
    if name == "learn":
        return source, out, ["learn", source, "-o", out]
    if name == "downsample":
        return source, out, ["downsample", source, "-o", out, "--rate", 0.3, "--select", "uniform"]
    return source, out, upsample(source, out)


def some(quick, everything):
    """Parameters of which only a few are for the quick run."""
    return [each if each in quick else pytest.param(each, marks=pytest.mark.slow) for each in everything]


@pytest.mark.parametrize(
    ("name", "n_kills"),
    [("in place", 6), *(pytest.param(name, 25, marks=pytest.mark.slow) for name in WAYS)],
)
def test_killed_at_any_moment(tmp_path, zygote, name, n_kills):
    source, out, call = call_of(name, tmp_path)
    before = source.read_bytes()
    (whole,) = zygote(call)
    assert whole.code == 0, whole.err
    new, old = out.read_bytes(), before if name == "in place" else b"old"
    killed = 0
    for share in np.linspace(0.02, 1.05, n_kills):
        out.write_bytes(old)
        (ended,) = zygote(call, kill_after=share * whole.seconds)
        assert ended.code in (0, -signal.SIGKILL), ended.err
        assert out.read_bytes() in (old, new)
        assert name == "in place" or source.read_bytes() == before
        killed += ended.code != 0
    assert killed
    # What is left behind is hidden, named after the file, and in the way of nobody.
    for path in set(tmp_path.iterdir()) - {source, out}:
        # downsample reads what it has written where relative references lead to the same files: beside OUT
        assert (path.is_dir() or name == "downsample") and path.name.startswith(f".{out.name}.")


@pytest.mark.parametrize("name", some(["out.usda"], OUTS))
def test_two_runs_on_one_output(tmp_path, zygote, name):
    source, out = make_clip(tmp_path / "in.usda"), tmp_path / name
    calls = [[*upsample(source, out), "--alpha", alpha] for alpha in (2, 3)]
    results = set()
    for call in calls:
        zygote(call)
        results.add(out.read_bytes())
    assert len(results) == 2
    for _ in range(3):
        assert [(ended.code, ended.err) for ended in zygote(*calls)] == [(0, "")] * 2
        assert out.read_bytes() in results
    assert left(tmp_path) == sorted(["in.usda", name])


def test_two_runs_in_place(tmp_path, zygote):
    source = make_clip(tmp_path / "in.usda", 20)
    ended = zygote(*[["upsample", source, "--in-place", "--factor", factor] for factor in (2, 3)])
    assert [(each.code, each.err) for each in ended] == [(0, "")] * 2
    layer = Sdf.Layer.FindOrOpen(str(source))
    assert layer.GetNumTimeSamplesForPath("/Rig/Anim.rotations") in {39, 58, 115}
    assert left(tmp_path) == ["in.usda"]


@pytest.mark.parametrize("size", some([1000], [0, 1, 1000, 20_000]))
@pytest.mark.parametrize("name", some(["out.usdc", "out.usdz", "from_bvh"], WAYS))
def test_no_room(tmp_path, zygote, name, size):
    """A limit on the size of files, which fails as a full disk does."""
    source, out, call = call_of(name, tmp_path)
    before = source.read_bytes()
    old = before if name == "in place" else b"old"
    out.write_bytes(old)
    listed = left(tmp_path)
    (ended,) = zygote(call, fsize=size)
    if ended.code == 0:
        assert len(out.read_bytes()) <= size and out.read_bytes() != old
        return
    assert (ended.code, ended.err.count("error: ")) == (1, 1), ended.err
    assert ended.err.splitlines()[-1].startswith(
        (f"error: {out}", f"error: {out.name}", f"error: {tempfile.gettempdir()} has no room")
    )
    assert (out.read_bytes(), source.read_bytes(), left(tmp_path)) == (old, before, listed)


@pytest.fixture
def full_disk(tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted = shutil.which("mount") and subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=16k", "tmpfs", disk], capture_output=True
    )
    if not mounted or mounted.returncode:
        pytest.skip("may not mount a small disk")
    yield disk
    subprocess.run(["umount", disk], check=True)


@pytest.mark.parametrize("name", OUTS)
def test_full_disk(tmp_path, zygote, full_disk, name):
    source, out = make_clip(tmp_path / "in.usda"), full_disk / name
    out.write_bytes(b"old")
    (ended,) = zygote(upsample(source, out))
    assert (ended.code, ended.err.count("error: ")) == (1, 1), ended.err
    assert out.name in ended.err
    assert (out.read_bytes(), left(full_disk)) == (b"old", [name])


def test_devices_are_not_replaced(tmp_path, refuse):
    source = make_clip(tmp_path / "in.usda", 4)
    os.mkfifo(tmp_path / "pipe.usda")
    sentence = refuse("upsample", source, "-o", tmp_path / "pipe.usda", "--factor", 2)
    assert sentence == "--out pipe.usda is not a file, but a device or a pipe; name a file."
    sentence = refuse("upsample", source, "--dry-run", "--factor", 2, "--report", "/dev/full")
    assert sentence == "--report /dev/full is not a file, but a device or a pipe; name a file."
    sentence = refuse("inspect", "/dev/full")
    assert sentence == "/dev/full is not a file; name a USD file."


as_nobody = pytest.mark.skipif(os.geteuid() != 0, reason="only root can become another user")


@as_nobody
def test_folder_that_may_not_be_written(folder, zygote):
    source = make_clip(folder / "in.usda", 4)
    (folder / "shut").mkdir(mode=0o755)
    out = folder / "shut" / "out.usda"
    (ended,) = zygote(upsample(source, out), uid=NOBODY)
    assert (ended.code, ended.err) == (
        1,
        f"error: --out {out}: the folder {out.parent} cannot be written; choose another.\n",
    )
    assert left(out.parent) == []


@as_nobody
def test_files_that_may_not_be_read_or_written(folder, zygote):
    source, out = make_clip(folder / "in.usda", 4), folder / "out.usda"
    source.chmod(0o444)
    before = source.read_bytes()
    (ended,) = zygote(upsample(source, out), uid=NOBODY)
    assert (ended.code, ended.err, out.exists(), source.read_bytes()) == (0, "", True, before)
    (ended,) = zygote(["upsample", source, "--in-place", "--factor", 2], uid=NOBODY)
    words = "is read-only; change its permissions, or choose another name."
    assert (ended.code, ended.err) == (1, f"error: --in-place {source} {words}\n")
    out.chmod(0o444)
    written = out.read_bytes()
    os.chown(out, 0, 0)
    (ended,) = zygote(upsample(source, out, "--alpha", 2), uid=NOBODY)
    assert (ended.code, ended.err, out.read_bytes()) == (1, f"error: --out {out} {words}\n", written)
    source.chmod(0)
    for verb in ("inspect", "learn"):
        rest = [] if verb == "inspect" else ["-o", folder / "new.usda"]
        (ended,) = zygote([verb, source, *rest], uid=NOBODY)
        assert (ended.code, ended.err) == (1, f"error: {source} cannot be read; change its permissions.\n")
    assert left(folder) == ["in.usda", "out.usda"]


@as_nobody
def test_file_that_the_input_needs_and_that_may_not_be_read(folder, zygote):
    make_clip(folder / "in.usda", 4)
    shot = Sdf.Layer.CreateNew(str(folder / "shot.usda"))
    shot.subLayerPaths = ["./in.usda"]
    shot.Save()
    UsdUtils.CreateNewUsdzPackage(str(folder / "shot.usda"), str(folder / "all.usdz"))
    (folder / "in.usda").chmod(0)
    (ended,) = zygote(["upsample", folder / "shot.usda", "-o", folder / "out.usda", "--factor", 2], uid=NOBODY)
    assert ended.code == 1 and "Traceback" not in ended.err
    assert ended.err.splitlines()[-1] == f"error: {folder}/shot.usda has no skeletal animation."
    assert left(folder) == ["all.usdz", "in.usda", "shot.usda"]
