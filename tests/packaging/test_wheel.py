"""The wheel holds everything that the packages have, and works in an environment of its own; needs a package index."""

import os
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest
from real_files import SHIPPED

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("geomstats_anim", "usd_tools")

pytestmark = pytest.mark.slow


def call(*command, cwd):
    """Run a command as a user would, away from the sources; return what it prints."""
    environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONHOME")}
    done = subprocess.run([str(word) for word in command], cwd=cwd, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Build the distributions; return the wheel, which is made from the other."""
    out = tmp_path_factory.mktemp("dist")
    call(sys.executable, "-m", "build", "--outdir", out, ROOT, cwd=out)
    (path,) = out.glob("*.whl")
    return path


def test_the_wheel_holds_what_the_packages_have(wheel):
    sources = {
        path.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for path in (ROOT / package).rglob("*")
        if path.is_file() and path.parent.name != "__pycache__"
    }
    packed = {
        name for name in zipfile.ZipFile(wheel).namelist() if name.startswith(PACKAGES) and ".dist-info" not in name
    }
    assert packed == sources
    assert {"usd_tools/comparison/report/page.html", "geomstats_anim/py.typed"} <= packed


def test_verbs_run_from_the_wheel(wheel, tmp_path):
    venv.create(tmp_path / "env", with_pip=True)
    programs = tmp_path / "env" / ("Scripts" if os.name == "nt" else "bin")
    call(programs / "python", "-m", "pip", "install", "-q", "--disable-pip-version-check", wheel, cwd=tmp_path)
    command, clip = programs / "geomstats-anim", SHIPPED / "punching.usdc"

    assert call(command, "--version", cwd=tmp_path).split()[-1] == wheel.name.split("-")[1]
    assert "36" in call(command, "inspect", clip, cwd=tmp_path)
    call(command, "upsample", clip, "-o", "more.usda", "--factor", 2, "--alpha", 4, cwd=tmp_path)
    assert (tmp_path / "more.usda").is_file()
    call(command, "compare", clip, "-o", "compared", "--rates", ".3", "--schemes", "slerp", cwd=tmp_path)
    assert "</html>" in (tmp_path / "compared" / "index.html").read_text("utf-8")
