"""Packages from strangers: members that climb out, bombs, and names in capitals; and what packing takes along."""

import zipfile

import pytest
from pxr import Sdf, Usd, UsdUtils
from rigs import ANIMATION, make_rig, read

from usd_tools.console.errors import ToolError
from usd_tools.files.packages import check_package, unpack


@pytest.fixture
def package(tmp_path):
    """Make a package with further members, each a name and its bytes; give its path."""

    def make(*members, compression=zipfile.ZIP_STORED):
        make_rig(tmp_path / "rig.usda", codes=range(8))
        assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "rig.usda"), str(tmp_path / "in.usdz"))
        (tmp_path / "rig.usda").unlink()
        with zipfile.ZipFile(tmp_path / "in.usdz", "a", compression) as archive:
            for name, data in members:
                archive.writestr(name, data)
        return tmp_path / "in.usdz"

    return make


@pytest.mark.parametrize(
    "name",
    ["/tmp/evil.txt", "../evil.txt", "a/../../evil.txt", "..\\evil.txt", "C:\\evil.txt", "//host/share/evil.txt"],
)
def test_members_outside_the_package_are_refused(tmp_path, package, refuse, name):
    path = package((name, b"evil"))
    sentence = refuse("upsample", path, "-o", tmp_path / "out.usdz", "--factor", 2)
    assert sentence == f"in.usdz has the member {name!r}, which lies outside the package; do not trust it."
    assert not (tmp_path.parent / "evil.txt").exists()


def test_the_first_file_is_where_it_was_unpacked(tmp_path):
    """Even of a package that nobody has checked, nothing outside the folder is written or read."""
    with zipfile.ZipFile(tmp_path / "in.usdz", "w") as archive:
        archive.writestr("/etc/../../secret.usda", b"x")
    folder = tmp_path / "there"
    folder.mkdir()
    first = unpack(tmp_path / "in.usdz", folder)
    assert first.is_relative_to(folder) and first.read_bytes() == b"x"


def test_a_member_that_is_listed_twice(tmp_path, package, refuse):
    with pytest.warns(UserWarning, match="Duplicate name"):
        path = package(("a.png", b"1"), ("a.png", b"2"))
    sentence = refuse("upsample", path, "-o", tmp_path / "out.usdz", "--factor", 2)
    assert sentence == "in.usdz lists the member 'a.png' twice; pack it again."


def test_bombs(tmp_path, package, refuse):
    path = package(("zeros.bin", bytes(50_000_000)), compression=zipfile.ZIP_DEFLATED)
    sentence = refuse("upsample", path, "-o", tmp_path / "out.usdz", "--factor", 2)
    assert sentence.startswith("in.usdz would unpack to ") and sentence.endswith(
        " times its size, which no valid usdz does; do not trust it."
    )


def test_the_size_that_a_package_may_unpack_to(tmp_path, package, run, refuse):
    path, out = package(("big.bin", bytes(3_000_000))), tmp_path / "out.usdz"
    sentence = refuse("upsample", path, "-o", out, "--factor", 2, "--max-unpacked", 0.002)
    assert sentence == "in.usdz would unpack to 0.003 GB; if you trust it, allow that with --max-unpacked."
    assert run("upsample", path, "-o", out, "--factor", 2, "--max-unpacked", 0.004)[0] == 0
    with pytest.raises(ToolError, match="--max-unpacked"):
        check_package(path, 2e6)
    assert "--max-unpacked" in refuse("upsample", path, "-o", out, "--factor", 2, "--max-unpacked", "-1", exit_code=2)


@pytest.mark.parametrize("data", [b"", b"PK\x05\x06" + bytes(18), b"PK\x03\x04 and so on"])
def test_broken_packages(tmp_path, data):
    (tmp_path / "in.usdz").write_bytes(data)
    for call in (lambda: check_package(tmp_path / "in.usdz", 1e9), lambda: unpack(tmp_path / "in.usdz", tmp_path)):
        with pytest.raises(ToolError, match="in.usdz is broken: "):
            call()


@pytest.mark.parametrize("verb", ["upsample", "downsample", "learn"])
def test_extensions_in_capitals(tmp_path, package, run, verb):
    path = package().rename(tmp_path / "IN.USDZ")
    options = {
        "upsample": ["--factor", 2],
        "downsample": ["--rate", 0.8, "--scheme", "slerp"],
        "learn": ["--rate", 0.5],
    }
    for name in ("OUT.USDZ", "out.Usda"):
        code, _, err = run(verb, path, "-o", tmp_path / name, *options[verb])
        assert (code, err) == (0, "")
        assert read(tmp_path / name)[0]
    with zipfile.ZipFile(tmp_path / "OUT.USDZ") as archive:
        assert not any(name.lower().endswith(".usdz") for name in archive.namelist())


def test_a_package_in_capitals_is_not_changed_in_place(tmp_path, package, refuse):
    path = package().rename(tmp_path / "IN.USDZ")
    sentence = refuse("upsample", path, "--in-place", "--factor", 2)
    assert sentence == "IN.USDZ is a package and cannot be changed in place; name another file with --out."


def test_what_is_packed_from_other_folders_is_listed(tmp_path, run):
    (tmp_path / "secret").mkdir()
    (tmp_path / "show" / "tex").mkdir(parents=True)
    for name in ("secret/key.png", "show/tex/skin.png"):
        (tmp_path / name).write_bytes(b"png")
    stage = make_rig(tmp_path / "show" / "in.usda")
    for attribute, name in (("a", "../secret/key.png"), ("b", "./tex/skin.png")):
        stage.GetPrimAtPath("/Rig").CreateAttribute(attribute, Sdf.ValueTypeNames.Asset).Set(name)
    stage.Save()
    source = tmp_path / "show" / "in.usda"
    for out, listed in ((tmp_path / "out.usdz", True), (tmp_path / "out.usda", False)):
        code, _, err = run("upsample", source, "-o", out, "--factor", 2)
        told = f"warning: {out} will hold ../secret/key.png, which is outside the folder of {source}.\n"
        assert (code, err) == (0, told if listed else "")
    again = run("upsample", tmp_path / "out.usdz", "-o", tmp_path / "again.usdz", "--factor", 2)
    assert again[0] == 0 and again[2] == ""
    assert Usd.Stage.Open(str(tmp_path / "again.usdz")).GetPrimAtPath(ANIMATION)
