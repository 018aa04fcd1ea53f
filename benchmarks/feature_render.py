"""Renders the scenes of test_scenes/features.py with both engines in one Blender; feature_agreement.py starts it:

    blender -b --factory-startup --addons ajar_render --python-exit-code 1 --python feature_render.py -- FOLDER SAMPLES SEEDS NAME ...
    PYTHON feature_render.py --zip ZIP -- FOLDER SAMPLES SEEDS NAME ...    in the Python of a bpy wheel, which installs the zip first

SEEDS is first:count. Opens FOLDER/<name>.blend and writes FOLDER/<name>_<engine>_<seed>.exr. Messages of Ajar about the scene are in the log, after a
line `FEATURE <name>`.
"""

import argparse
import os
import sys
from pathlib import Path

import bpy


def install(zip_file: str) -> None:
    bpy.ops.extensions.package_install_files(filepath=zip_file, repo="user_default", enable_on_install=True)
    if "cycles" not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module="cycles")


def main() -> None:
    parser = argparse.ArgumentParser(prog="feature_render.py", description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="of the .blend files and the images")
    parser.add_argument("samples", type=int, help="per pixel")
    parser.add_argument("seeds", help="first:count")
    parser.add_argument("names", nargs="*", help="scenes")
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    folder = options.folder
    first, count = map(int, options.seeds.split(":"))
    for name in options.names:
        bpy.ops.wm.open_mainfile(filepath=str(folder / f"{name}.blend"), load_ui=False)
        scene = bpy.context.scene
        image = scene.render.image_settings
        if hasattr(image, "media_type"):   # 5.0
            image.media_type = "IMAGE"
        image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGBA", "32", "ZIP"
        scene.ajar.samples = scene.cycles.samples = options.samples
        print(f"FEATURE {name}", flush=True)
        for engine in ("AJAR", "CYCLES"):
            scene.render.engine = engine
            for seed in range(first, first + count):
                scene.cycles.seed = scene.ajar.seed = seed
                scene.render.filepath = str(folder / f"{name}_{engine.lower()}_{seed}.exr")
                bpy.ops.render.render(write_still=True)


if "--zip" in sys.argv:
    install(sys.argv[sys.argv.index("--zip") + 1])
    main()
    sys.stdout.flush()
    os._exit(0)
main()
