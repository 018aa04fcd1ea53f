#!/usr/bin/python3
"""make release: lays the zips of out/ out as a folder that any web server can serve, out/release:

    index.json              the repository that Blender reads (the format of `blender --command extension server-generate`)
    ajar-*-linux-x64.zip    the extension, and the legacy add-on in legacy/
    SHA256SUMS              of all other files; `sha256sum -c SHA256SUMS` checks them
    sbom.json               what is bundled, with versions, licences and hashes (CycloneDX 1.5)
    RELEASE_NOTES.md        what has changed since the release before, by area

In Blender: Preferences > Get Extensions > Repositories > Add Remote Repository, with the address of index.json. Blender then offers updates itself.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
import shutil
import subprocess
import sys
import tomllib
import uuid
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# The fields of a manifest that an index has, in the order of Blender's tool.
FIELDS = ("schema_version", "id", "name", "tagline", "version", "type", "maintainer", "license", "blender_version_min", "blender_version_max", "website", "copyright", "permissions", "tags",
          "platforms", "wheels", "python_versions")


class ReleaseError(Exception):
    """Why there is no release, as text."""


def sha256(path: Path) -> str:
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def index(archives: list[Path]) -> dict:
    """The repository of these extensions, whose addresses are relative to that of index.json."""
    data = []
    for archive in archives:
        with zipfile.ZipFile(archive) as opened:
            manifest = tomllib.loads(opened.read("blender_manifest.toml").decode())
        entry = {field: manifest[field] for field in FIELDS if field in manifest}
        data.append(entry | {"archive_url": f"./{archive.name}", "archive_size": archive.stat().st_size, "archive_hash": f"sha256:{sha256(archive)}"})
    return {"version": "v1", "blocklist": [], "data": data}


# ---- What is bundled ------------------------------------------------------------------------------------------------------

# Name, licence (SPDX), the part of the names of its files in the zip, the text of its licence there, and where it comes from. No files: it is compiled into the module.
BUNDLED = (
    ("Embree", "Apache-2.0", "libajar_embree", "Embree.txt", r"^embreex==(\S+)", "pkg:pypi/embreex@{}"),
    ("oneTBB", "Apache-2.0", "libajar_tbb", "Embree.txt", r"^embreex==(\S+)", "pkg:pypi/embreex@{}"),
    ("OpenImageIO", "Apache-2.0", "libajar_OpenImageIO", "OpenImageIO.txt", r"^openimageio==(\S+)", "pkg:pypi/openimageio@{}"),
    ("Open Image Denoise", "Apache-2.0", "OpenImageDenoise", "OpenImageDenoise.txt", r"^pyoidn==(\S+)", "pkg:pypi/pyoidn@{}"),
    ("OpenSubdiv", "Apache-2.0", "", "OpenSubdiv.txt", r"opensubdiv_([\d.]+)\.orig", "pkg:deb/debian/opensubdiv@{}"),
    ("pybind11", "BSD-3-Clause", "", "", r"^pybind11==(\S+)", "pkg:pypi/pybind11@{}"),
    ("fmt", "MIT", "", "", r"libfmt-dev_([\d.]+)", "pkg:deb/debian/fmtlib@{}"),
)
# Headers of the build machine that are compiled in: package of Debian, licence.
COMPILED = (("GLM", "libglm-dev", "MIT"), ("nlohmann JSON", "nlohmann-json3-dev", "MIT"), ("libstdc++", "libstdc++-12-dev", "GPL-3.0-or-later WITH GCC-exception-3.1"))


def locked(pattern: str) -> tuple[str, str]:
    """The version in the lock files, and the sha256 of what was downloaded."""
    for lock in sorted((ROOT / "tools" / "extension").glob("*.lock")):
        for line in lock.read_text().splitlines():
            if found := re.search(pattern, line):
                digest = re.search(r"\b[0-9a-f]{64}\b", line)
                return found[1], digest[0] if digest else ""
    raise ReleaseError(f"no lock file has {pattern}")


def debian_version(package: str) -> str:
    done = subprocess.run(["dpkg-query", "-W", "-f=${Version}", package], capture_output=True, text=True, check=False)
    return done.stdout.strip() or "unknown"


def bill_of_materials(archive: Path, version: str, commit: str) -> dict:
    """Every library in the zip belongs to a component. Raises ReleaseError for one that does not, and for a licence whose text is missing."""
    components, known = [], set()
    with zipfile.ZipFile(archive) as opened:
        names = set(opened.namelist())
        for name, licence, part, text, pattern, purl in BUNDLED:
            found, digest = locked(pattern)
            files = sorted(path for path in names if part and path.startswith("ajar/lib/") and part in path)
            if part and not files:
                continue
            known |= set(files)
            if text and f"ajar/licenses/{text}" not in names:
                raise ReleaseError(f"{archive.name} has {name} and not its licence, ajar/licenses/{text}")
            components.append({"type": "library", "name": name, "version": found, "purl": purl.format(found), "licenses": [{"license": {"id": licence}}],
                               "hashes": [{"alg": "SHA-256", "content": digest}] if digest else [],
                               "properties": [{"name": f"file:{path}", "value": hashlib.sha256(opened.read(path)).hexdigest()} for path in files]})
        strange = sorted(path for path in names if path.startswith("ajar/lib/") and path not in known)
    if strange:
        raise ReleaseError(f"{archive.name} has libraries that no component names: {', '.join(strange)}")
    for name, package, licence in COMPILED:
        found = debian_version(package)
        entry = {"expression": licence} if " " in licence else {"license": {"id": licence}}
        components.append({"type": "library", "name": name, "version": found, "purl": f"pkg:deb/debian/{package}@{found}", "licenses": [entry]})
    digest = sha256(archive)
    return {"bomFormat": "CycloneDX", "specVersion": "1.5", "serialNumber": f"urn:uuid:{uuid.UUID(digest[:32])}", "version": 1,
            "metadata": {"component": {"type": "application", "name": "Ajar", "version": version, "licenses": [{"license": {"id": "GPL-3.0-or-later"}}],
                                       "hashes": [{"alg": "SHA-256", "content": digest}], "properties": [{"name": "commit", "value": commit}]}},
            "components": components}


# ---- Notes ---------------------------------------------------------------------------------------------------------------

def git(*arguments: str) -> str:
    return subprocess.run(["git", "-C", str(ROOT), *arguments], capture_output=True, text=True, check=True).stdout.strip()


def notes(version: str) -> str:
    """The subjects of the commits since the last tag, by the area that they begin with."""
    tags = git("tag", "--list", "v*", "--sort=-version:refname").split()
    before = next((tag for tag in tags if tag != f"v{version}"), "")
    areas: dict[str, list[str]] = {}
    for subject in git("log", "--reverse", "--no-merges", "--format=%s", *([f"{before}..HEAD"] if before else ["HEAD"])).splitlines():
        area, found, text = subject.partition(": ")
        for name in (area.split(", ") if found else ["other"]):
            areas.setdefault(name.strip(), []).append(text if found else subject)
    lines = [f"# Ajar {version}", "", f"Changes since {before or 'the beginning'}, at {git('rev-parse', '--short', 'HEAD')}.", ""]
    for area in sorted(areas):
        lines += [f"## {area}", "", *(f"* {text}" for text in areas[area]), ""]
    return "\n".join(lines)


def make(source: Path, target: Path) -> None:
    archives = sorted(path for path in source.glob("ajar-*-linux-x64.zip") if "legacy" not in path.name)
    if not archives:
        raise ReleaseError(f"{source} has no extension (make extension builds it)")
    archive = archives[-1]
    with zipfile.ZipFile(archive) as opened:
        version = tomllib.loads(opened.read("blender_manifest.toml").decode())["version"]
    shutil.rmtree(target, ignore_errors=True)
    (target / "legacy").mkdir(parents=True)
    shutil.copy2(archive, target)
    for legacy in source.glob(f"ajar-{version}-legacy-linux-x64.zip"):
        shutil.copy2(legacy, target / "legacy")   # no extension: Blender's tool would refuse it in the folder of the index
    commit = git("rev-parse", "HEAD") + ("-changed" if git("status", "--porcelain", "--untracked-files=no") else "")
    (target / "index.json").write_text(json.dumps(index([target / archive.name]), indent=2) + "\n")
    (target / "sbom.json").write_text(json.dumps(bill_of_materials(archive, version, commit), indent=2) + "\n")
    (target / "RELEASE_NOTES.md").write_text(notes(version))
    files = sorted(path for path in target.rglob("*") if path.is_file())
    (target / "SHA256SUMS").write_text("".join(f"{sha256(path)}  {path.relative_to(target)}\n" for path in files))
    print(f"{target}: {archive.name} and {len(files) - 1} other files")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--zips", type=Path, default=ROOT / "out")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "release")
    given = parser.parse_args()
    try:
        make(given.zips, given.out)
    except ReleaseError as error:
        print(f"release: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
