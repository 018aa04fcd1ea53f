"""The add-on in a clean profile: it comes up, goes away, and leaves nothing behind."""


def test_engine_is_offered(blender):
    assert "AJAR" in blender("-E", "help").stdout


def test_registers_twice_and_leaves_nothing(blender, tmp_path):
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
assert not [p for p in panels() if not p.startswith("AJAR_")]
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
from ajar_render import properties
for items in (properties.integrator_items(), properties.DIRECT_ITEMS, properties.FILTER_ITEMS):
    assert all(len(item) == 4 for item in items) and len({item[3] for item in items}) == len(items)
assert bpy.context.scene.ajar.integrator in ("path", "auto")
print("all is well")
""")
    result = blender("--python-exit-code", 1, "--python", script)
    assert "all is well" in result.stdout, result.stdout


def test_panels_draw_only_what_exists(blender, tmp_path):
    script = tmp_path / "script.py"
    script.write_text("""
import bpy
from ajar_render import ui

class Layout:
    drawn = 0
    def prop(self, data, name, **more):
        assert name in data.bl_rna.properties, (data, name)
        Layout.drawn += 1
    def prop_search(self, data, name, owner, collection, **more):
        self.prop(data, name)
        assert collection in owner.bl_rna.properties
    def template_list(self, kind, identifier, owner, collection, active_owner, active, **more):
        assert hasattr(bpy.types, kind) and collection in owner.bl_rna.properties and active in active_owner.bl_rna.properties
    def menu(self, kind, **more): assert hasattr(bpy.types, kind), kind
    def label(self, text, **more): assert text
    def operator(self, name, **more):
        category, operator = name.split(".")
        assert name == getattr(getattr(bpy.ops, category), operator).idname_py()
        known = getattr(getattr(bpy.ops, category), operator).get_rna_type().properties
        class Properties:
            def __setattr__(self, key, value): assert key in known, (name, key)
        return Properties()
    def separator(self): pass
    def column(self, **more): return Layout()
    row = split = column

class Self:
    layout = Layout()
    column = ui.AjarPanel.column

bpy.context.scene.render.engine = "AJAR"
# The panel of light paths is there for curves of their collection only.
paths = bpy.data.collections.new(bpy.context.scene.ajar.hint_collection)
bpy.context.scene.collection.children.link(paths)
path = bpy.data.objects.new("Path", bpy.data.curves.new("Path", "CURVE"))
paths.objects.link(path)
bpy.context.view_layer.objects.active = path
# That of statistics after a render only.
assert not ui.AJAR_RENDER_PT_statistics.poll(bpy.context)
bpy.context.scene.render.resolution_percentage, bpy.context.scene.ajar.samples = 2, 1
bpy.ops.render.render()
camera = bpy.context.scene.camera.data
camera.type = "PANO"
with bpy.context.temp_override(camera=camera, world=bpy.context.scene.world):
    for panel in ui.CLASSES:
        assert panel.poll(bpy.context), panel
        panel.draw(Self(), bpy.context)
assert Layout.drawn > 35, Layout.drawn
print("all is well")
""")
    result = blender("--python-exit-code", 1, "--python", script)
    assert "all is well" in result.stdout, result.stdout
