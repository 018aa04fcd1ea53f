"""A scene file from a stranger: which files a render opens, and that it starts no program and opens no connection (docs/developer/security.md)."""
from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(os.environ.get("AJAR_BUILD", Path(__file__).resolve().parents[2] / "build" / "release")) / "python"))
import ajar

BUILD = Path(os.environ.get("AJAR_BUILD", Path(__file__).resolve().parents[2] / "build" / "release"))
SIZE = 16
# Libraries of the system, what they configure themselves with, and what describes the machine.
SYSTEM = re.compile(r"^(/usr|/lib|/lib64|/etc/(ld\.so|nsswitch|passwd$|localtime|fonts|ImageMagick|gai\.conf|ssl)|/proc|/sys|/dev/(null|urandom|random|shm|dri|nvidia)|/opt|/root/\.cache|/run)")


def can_trace() -> bool:
    """Some containers forbid it."""
    return shutil.which("strace") is not None and subprocess.run(["strace", "-f", "-o", os.devnull, "true"], capture_output=True, check=False).returncode == 0


pytestmark = pytest.mark.skipif(not can_trace(), reason="strace is not installed, or may not trace here")


def opened(folder: Path, *arguments: object) -> tuple[set[str], set[str], str]:
    """The files that ajar-render reads and that it writes, and all of the trace."""
    trace = folder / "trace"
    done = subprocess.run(["strace", "-f", "-qq", "-s", "4096", "-o", str(trace), "-e", "trace=openat,open,creat,rename,unlink,mkdir,execve,connect,symlink,link", str(BUILD / "ajar-render"),
                           *map(str, arguments)], capture_output=True, text=True, check=False, cwd=folder)
    assert done.returncode == 0, done.stderr
    text = trace.read_text(errors="replace")
    reads, writes = set(), set()
    for path, flags, result in re.findall(r'open(?:at)?\((?:AT_FDCWD, )?"([^"]*)", ([A-Z_|0-9]+)[^)]*\)\s+= (-?\d+)', text):
        if int(result) >= 0:
            (writes if re.search("O_WRONLY|O_RDWR|O_CREAT", flags) else reads).add(str((folder / path).resolve()))
    return reads, writes, text


@pytest.fixture
def scene(tmp_path) -> Path:
    """A file whose images are where an image is, where other things are, and where nothing is."""
    (tmp_path / "work").mkdir()
    (tmp_path / "secret").write_text("a secret that no image names")
    ajar.write_image(str(tmp_path / "named.png"), np.full((4, 4, 4), 0.5, np.float32))
    description = ajar.SceneDescription()
    description.camera.present = True
    description.camera.world_from_camera = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 3]
    description.settings.width = description.settings.height = SIZE
    description.settings.region = [0, 0, SIZE, SIZE]
    description.settings.texture_cache = description.settings.texture_cache_generate = True   # files of tiles are written only if the command line asks for them
    names = (str(tmp_path / "named.png"), str(tmp_path / "none" / "file.png"), "/dev/zero", str(tmp_path), "http://127.0.0.1:9/image.png", f"| touch {tmp_path}/run")
    for number, name in enumerate(names):
        image = description.add_image(name=name, path=name)
        graph = ajar.NodeGraph()
        texture, emission = graph.add_node("ShaderNodeTexImage", "Image"), graph.add_node("ShaderNodeEmission", "Emission")
        graph.add_property(texture, "image", numbers=[image])
        graph.add_input(emission, "Color", link=ajar.NodeLink(texture, "Color"))
        graph.add_input(emission, "Strength", (1.0, 0.0, 0.0, 0.0))
        graph.surface = ajar.NodeLink(emission, "Emission")
        material = description.add_material(name=name, graph=graph)
        left = -3.0 + number
        mesh = description.add_mesh(name=name, positions=[(left, -3, 0), (left + 1, -3, 0), (left + 1, 3, 0), (left, 3, 0)], triangles=[(0, 1, 2), (0, 2, 3)])
        description.add_instances([description.add_object(name=name, mesh=mesh, materials=[material])], np.eye(3, 4, dtype=np.float32).reshape(1, 12))
    path = tmp_path / "work" / "stranger.ajar"
    ajar.save_description(description, str(path))
    return path


def test_a_render_reads_only_what_the_scene_names_and_writes_only_what_was_asked_for(scene):
    folder = scene.parent
    reads, writes, trace = opened(folder, scene, folder / "out.exr", "--checkpoint", folder / "kept", "--stats", folder / "stats.json", "--samples", 1, "--threads", 1)
    own = {path for path in reads if not SYSTEM.match(path) and not path.startswith(str(BUILD.resolve()))}
    named = {str(scene), str(folder.parent / "named.png")}
    assert named <= own, "the image that is there is read"
    assert own <= named | {str(folder), str(folder.parent)}, own
    written = {re.sub(r"\.part-.*", "", path) for path in writes if not SYSTEM.match(path)}
    assert written == {str(folder / name) for name in ("out.exr", "kept", "stats.json")}, written
    assert trace.count("execve(") == 1 and "connect(" not in trace
    assert not (folder.parent / "run").exists()
    assert sorted(path.name for path in folder.iterdir()) == ["kept", "out.exr", "stats.json", "stranger.ajar", "trace"]
