"""Files that are broken in the middle: what OpenUSD says of them names the file, in one line."""

import subprocess
import sys
from pathlib import Path

import pytest
from pxr import Sdf, UsdUtils
from rigs import ANIMATION, make_rig

ROOT = Path(__file__).resolve().parents[2]
VERBS = {"inspect": [], "upsample": ["--factor", 2], "learn": []}


@pytest.fixture(params=VERBS)
def refused(request, tmp_path, refuse):
    """Run a verb on a file; give the sentence."""

    def call(path):
        out = [] if request.param == "inspect" else ["-o", tmp_path / "out.usda"]
        return refuse(request.param, path, *out, *VERBS[request.param])

    return call


def test_text_that_is_not_utf8(tmp_path, refused):
    make_rig(tmp_path / "in.usda")
    text = (tmp_path / "in.usda").read_bytes()
    (tmp_path / "in.usda").write_bytes(text.replace(b"quatf[] rotations", b"quatf[] \xff\x80"))
    assert refused(tmp_path / "in.usda").startswith("in.usda cannot be read as USD: ")


def test_binary_file_with_a_broken_value(tmp_path, refused):
    """Values are read only when they are asked for, long after the file is opened."""
    make_rig(tmp_path / "in.usda")
    Sdf.Layer.FindOrOpen(str(tmp_path / "in.usda")).Export(str(tmp_path / "in.usdc"))
    data = (tmp_path / "in.usdc").read_bytes()
    before = data.index(b"PXR-USDC")
    # the values come first in the file; the table of contents, at the end, stays
    (tmp_path / "in.usdc").write_bytes(data[: before + 88] + b"\xff" * 600 + data[before + 688 :])
    sentence = refused(tmp_path / "in.usdc")
    assert "in.usdc cannot be read as USD: " in sentence and len(sentence) < 600


def test_package_with_a_wrong_checksum(tmp_path, refuse):
    make_rig(tmp_path / "in.usda")
    UsdUtils.CreateNewUsdzPackage(str(tmp_path / "in.usda"), str(tmp_path / "in.usdz"))
    data = (tmp_path / "in.usdz").read_bytes()
    (tmp_path / "in.usdz").write_bytes(data.replace(b'upAxis = "Z"', b'upAxis = "Y"'))
    sentence = refuse("upsample", tmp_path / "in.usdz", "-o", tmp_path / "out.usdz", "--factor", 2)
    assert sentence == "in.usdz is broken: Bad CRC-32 for file 'in.usda'; pack it again."


def test_rest_pose_of_an_unknown_type(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    text = (tmp_path / "in.usda").read_text()
    (tmp_path / "in.usda").write_text(text.replace("matrix4d[] restTransforms", "rotten[] restTransforms"))
    assert run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)[0] == 0


def test_output_that_openusd_cannot_read_again(tmp_path, refuse, monkeypatch):
    """A damaged usdc may hold what usda cannot spell."""
    make_rig(tmp_path / "in.usda")
    export = Sdf.Layer.Export

    def damaged(layer, path, **rest):
        done = export(layer, path, **rest)
        Path(path).write_text(Path(path).read_text() + "}")
        return done

    monkeypatch.setattr(Sdf.Layer, "Export", damaged)
    sentence = refuse("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2, "--flatten")
    assert sentence.startswith("out.usda could not be read back: out.usda:")


@pytest.mark.slow
def test_thousands_of_broken_files():
    """Never a traceback, a hang, a file left behind or a changed input; what OpenUSD itself dies of is told apart."""
    command = [sys.executable, "-m", "tests.fuzz", "--inputs", "10000"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, errors="replace")
    print(done.stdout)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        (
            "timeCodesPerSecond = 24",
            "timeCodesPerSecond = 0",
            f"{ANIMATION}: its stage has 0 time codes per second",
        ),
        (
            "timeCodesPerSecond = 24",
            "timeCodesPerSecond = -24",
            f"{ANIMATION}: its stage has -24 time codes per second",
        ),
        (
            "timeCodesPerSecond = 24",
            "timeCodesPerSecond = 1e-320",
            f"{ANIMATION}: time code 1, at 9.99989e-321 per second, is",
        ),
        (
            "            3: [(",
            "            inf: [(",
            f"{ANIMATION}: time code inf, at 24 per second, is not later than the",
        ),
        (
            "            3: [(",
            "            1e308: [(",
            f"{ANIMATION} cannot be interpolated: rotations has a value that is",
        ),
    ],
)
def test_times_that_cannot_be_computed_with(tmp_path, refuse, old, new, sentence):
    make_rig(tmp_path / "in.usda")
    text = (tmp_path / "in.usda").read_text()
    assert old in text
    (tmp_path / "in.usda").write_text(text.replace(old, new))
    found = refuse("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert found.startswith(sentence)
