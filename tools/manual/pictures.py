#!/usr/bin/python3
"""Makes the pictures of the manual, docs/manual/*.jpg, from Blender's window on a virtual display.

    tools/manual/pictures.py [--build build/release] [NAME ...]     all pictures, or those whose names begin with NAME

`inside.py` operates the user interface and takes screenshots. This script crops and scales them.
blender_5.2.jpg is the picture `blender` of this script, made in the Debian of tools/newest.sh. hint_6_keyhole.jpg shows two renders and is not made
by this script.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
WINDOW = ROOT / "tests" / "blender" / "window"
OUT = ROOT / "docs" / "manual"
SIZE = (1400, 900)
MAX_BYTES = 200_000
PROPERTIES = 400
TABS, HEADER = 36, 62      # pixels of the properties beside and above the panels


def trimmed(image: Image.Image) -> Image.Image:
    """Remove the empty rows of a single colour at the bottom of a column of panels."""
    image = image.crop((TABS, HEADER, image.width - 2, image.height - 4))
    pixels = np.asarray(image).astype(int)
    used = np.flatnonzero(np.abs(pixels[:, 4:-14] - pixels[-30, 10]).max(axis=(1, 2)) > 6)
    return image.crop((0, 0, image.width, min(image.height, int(used[-1]) + 10)))


def save(image: Image.Image, path: Path) -> None:
    quality = 92
    image.save(path, quality=quality, optimize=True)
    while path.stat().st_size > MAX_BYTES:
        quality -= 4
        image.save(path, quality=quality, optimize=True)
    print(f"{path.name}: {image.width} x {image.height}, {path.stat().st_size // 1000} kB")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--build", type=Path, default=ROOT / "build" / "release")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        subprocess.run([ROOT / "tools" / "install_addon.sh", options.build, folder / "profile"], check=True)
        read, write = os.pipe()
        server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", f"{SIZE[0]}x{SIZE[1]}x24", "-nolisten", "tcp"], pass_fds=[write],
                                  stderr=subprocess.DEVNULL)
        os.close(write)
        try:
            with os.fdopen(read) as number:
                display = f":{number.readline().strip()}"
            result = subprocess.run(
                [os.environ.get("BLENDER", "blender"), "--factory-startup", "--enable-event-simulate", "--window-geometry", "0", "0", *map(str, SIZE),
                 "--addons", "ajar_render", "--python", WINDOW / "drive.py", "--", Path(__file__).with_name("inside.py"), folder / "result.json",
                 folder, ROOT, *options.names],
                env=os.environ | {"BLENDER_USER_CONFIG": str(folder / "profile" / "config"), "BLENDER_USER_SCRIPTS": str(folder / "profile" / "scripts"),
                                  "DISPLAY": display, "LIBGL_ALWAYS_SOFTWARE": "1"}, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        finally:
            server.terminate()
            server.wait()
        if result.returncode != 0:
            sys.exit(result.stdout[-4000:])
        for picture in sorted(folder.glob("*.png")):
            image = Image.open(picture).convert("RGB")
            if picture.name.startswith("hint_2"):
                image = image.crop((0, 0, image.width - PROPERTIES, image.height))   # the status bar with the keys is below the view
            save(trimmed(image) if picture.name.startswith("panel_") else image, options.out / f"{picture.stem}.jpg")


if __name__ == "__main__":
    main()
