"""Tests of the add-on in a clean profile: it registers, unregisters, and leaves no data behind."""


def test_engine_is_registered(blender):
    assert "AJAR" in blender("-E", "help").stdout


def test_it_registers_twice_and_leaves_no_data(blender, tmp_path):
    script = tmp_path / "script.py"
    script.write_text("""
import addon_utils, bpy
def panels():
    return {p.__name__ for p in bpy.types.Panel.__subclasses__() if "AJAR" in getattr(p, "COMPAT_ENGINES", ())}
assert hasattr(bpy.context.scene, "ajar")
assert {"RENDER_PT_output", "RENDER_PT_format"} & panels(), panels()
assert "AJAR_RENDER_PT_sampling" in panels()
before = panels()
addon_utils.disable("ajar_render")
assert not hasattr(bpy.types.Scene, "ajar")
assert not [p for p in panels() if not p.startswith(("AJAR_", "NODE_AJAR_"))]
addon_utils.enable("ajar_render")
assert panels() == before, panels() ^ before
print("all is well")
""")
    result = blender("--python-exit-code", 1, "--python", script)
    assert result.returncode == 0 and "all is well" in result.stdout, result.stdout


def test_every_enum_item_has_its_number(blender, tmp_path):
    script = tmp_path / "script.py"
    script.write_text("""
import bpy
from ajar_render import core_settings
choices = [core_settings.items(name) for name, info in core_settings.SETTINGS.items() if info.type in ("choice", "name")]
assert len(choices) == 7
for items in choices:
    assert all(len(item) == 4 for item in items) and len({item[3] for item in items}) == len(items)
assert bpy.context.scene.ajar.integrator in ("path", "auto")
print("all is well")
""")
    result = blender("--python-exit-code", 1, "--python", script)
    assert "all is well" in result.stdout, result.stdout
