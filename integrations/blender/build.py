"""Build the Blender extension: python integrations/blender/build.py -o geomstats_anim_blender.zip.

In Blender: Edit > Preferences > Get Extensions > Install from Disk. Nothing but Python's own library is needed.
"""

from __future__ import annotations

import argparse
import re
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SOURCE = HERE / "geomstats_anim_blender"
SHARED = (ROOT / "usd_tools" / "serving" / "messages.py", ROOT / "LICENSE")
"""Files that the extension has a copy of."""


def build(out: Path) -> None:
    """Write the extension as a zip, the same bytes for the same sources.

    Parameters
    ----------
    out : Path
    """
    version = re.search(r'__version__ = "(\d+\.\d+\.\d+)', (ROOT / "geomstats_anim" / "_version.py").read_text())
    assert version, "geomstats_anim/_version.py has no version."
    files = {path.name: path.read_bytes() for path in (*SOURCE.glob("*.py"), *SHARED)}
    manifest = (SOURCE / "blender_manifest.toml").read_text("utf-8")
    manifest = re.sub(r"^version = .*$", f'version = "{version[1]}"', manifest, flags=re.MULTILINE)
    files["blender_manifest.toml"] = manifest.encode()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            archive.writestr(zipfile.ZipInfo(name), files[name], zipfile.ZIP_DEFLATED)


def main() -> None:
    """Read the command line, and build."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--out", type=Path, default=Path("geomstats_anim_blender.zip"), help="zip to write")
    out = parser.parse_args().out
    build(out)
    print(f"Wrote {out}.")


if __name__ == "__main__":
    main()
