"""Write docs/coverage.md: what Ajar makes of every shader node, output, input and choice that the running Blender has.

    PYTHONPATH=build/release/python blender -b --factory-startup --python-exit-code 1 --python tools/write_coverage.py -- docs/coverage.md

Every node is put into materials of its own, once for each output and each choice, exported and compiled. What the compiler reports about
it is the answer; what it does not know itself stands in APPROXIMATED below. An input or switch that no source file names is ignored.
"""

import re
import sys
from pathlib import Path

import bpy

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from python_addon import properties                            # noqa: E402
from python_addon.ajar_module import ajar                     # noqa: E402
from python_addon.export import export_scene                   # noqa: E402
from python_addon.headless import Options                      # noqa: E402

# What differs from Cycles although nothing is reported: node, or (node, property, choice).
APPROXIMATED: dict[object, str] = {
    ("ShaderNodeBsdfGlossy", "distribution", "MULTI_GGX"): "energy compensated, not a walk between facets (docs/agreement.md)",
    ("ShaderNodeBsdfAnisotropic", "distribution", "MULTI_GGX"): "energy compensated, not a walk between facets (docs/agreement.md)",
    ("ShaderNodeBsdfGlass", "distribution", "MULTI_GGX"): "energy compensated, not a walk between facets (docs/agreement.md)",
    ("ShaderNodeBsdfPrincipled", "distribution", "MULTI_GGX"): "energy compensated, not a walk between facets (docs/agreement.md)",
    ("ShaderNodeBsdfPrincipled", "subsurface_method", "BURLEY"): "a random walk of the same radius",
    ("ShaderNodeSubsurfaceScattering", "falloff", "BURLEY"): "a random walk of the same radius",
    "ShaderNodeBump": "heights a pixel apart as seen by the camera; Cycles measures the pixel along the path",
    "ShaderNodeDisplacement": "shown as bump, the surface stays where it is",
    "ShaderNodeVectorDisplacement": "shown as bump, the surface stays where it is",
    "ShaderNodeNormalMap": "each triangle has its own tangent; Cycles smooths them",
    "ShaderNodeTangent": "each triangle has its own tangent along a UV map; Cycles smooths them",
    "ShaderNodeWireframe": "with Pixel Size: pixels as seen by the camera; Cycles measures them along the path",
    "ShaderNodeTexNoise": "Blender 4.2 and later repeat it beyond 100 000",
}
# Looked through by the exporter, so that the compiler never meets them.
STRUCTURE = {"NodeGroupInput", "NodeGroupOutput", "NodeReroute", "NodeFrame", "ShaderNodeGroup", "ShaderNodeCustomGroup", "ShaderNodeTree"}
OUTPUTS = {"ShaderNodeOutputMaterial", "ShaderNodeOutputWorld", "ShaderNodeOutputLight", "ShaderNodeOutputLineStyle", "ShaderNodeOutputAOV"}
BRANCHES = {"ShaderNodeMixShader", "ShaderNodeAddShader"}
# Inputs that Blender never shows, and a switch of the compositor.
INTERNAL = {"Weight", "use_alpha"}
COMMON = set(bpy.types.Node.bl_rna.properties.keys())


def node_types() -> list[str]:
    tree = bpy.data.materials.new("probe")
    tree.use_nodes = True
    found = []
    for name in sorted(dir(bpy.types)):
        if not name.startswith("ShaderNode") or name in STRUCTURE | OUTPUTS:
            continue
        try:
            tree.node_tree.nodes.new(name)
        except RuntimeError:       # a base class, or for another tree
            continue
        found.append(name)
    bpy.data.materials.remove(tree)
    return found


def choices(node: bpy.types.Node) -> list[tuple[str, str]]:
    """Every value of every enumeration that the node adds to those all nodes have."""
    found = []
    for prop in node.bl_rna.properties:
        if prop.identifier in COMMON or prop.type != "ENUM" or prop.is_readonly or prop.is_enum_flag:
            continue
        for item in prop.enum_items:
            try:
                setattr(node, prop.identifier, item.identifier)
            except TypeError:      # not in this state of the node
                continue
            found.append((prop.identifier, item.identifier))
    return found


class Probes:
    """One mesh with a material for each question."""

    def __init__(self) -> None:
        self.mesh = bpy.data.meshes.new("probe")
        self.mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
        self.keys: dict[str, tuple] = {}

    def ask(self, type_: str, choice: tuple[str, str] | None, output: str) -> None:
        material = bpy.data.materials.new(f"probe {len(self.keys)}")
        material.use_nodes = True
        nodes, links = material.node_tree.nodes, material.node_tree.links
        nodes.clear()
        node, end = nodes.new(type_), nodes.new("ShaderNodeOutputMaterial")
        if choice:
            setattr(node, *choice)
        socket = next((s for s in node.outputs if s.identifier == output and s.enabled), None)
        if socket is None:
            bpy.data.materials.remove(material)
            return
        if type_ in BRANCHES:
            links.new(nodes.new("ShaderNodeBsdfDiffuse").outputs[0], node.inputs[-1])
        if type_ in ("ShaderNodeTexImage", "ShaderNodeTexEnvironment"):
            node.image = bpy.data.images.get("probe") or bpy.data.images.new("probe", 2, 2)
        if type_ == "ShaderNodeTexIES":
            node.filepath = str(ROOT / "tests" / "core" / "ies" / "half_1991.ies")
            node.ies = bpy.data.texts.get("half_1991.ies") or bpy.data.texts.load(node.filepath)
        if type_ in ("ShaderNodeDisplacement", "ShaderNodeVectorDisplacement"):
            links.new(socket, end.inputs["Displacement"])
            links.new(nodes.new("ShaderNodeBsdfDiffuse").outputs[0], end.inputs["Surface"])
        elif socket.type == "SHADER":
            links.new(socket, end.inputs["Volume" if "Volume" in type_ else "Surface"])
        else:
            emission = nodes.new("ShaderNodeEmission")
            links.new(socket, emission.inputs["Color"])
            links.new(emission.outputs[0], end.inputs["Surface"])
        self.mesh.materials.append(material)
        self.keys[material.name] = (type_, choice, output)

    def answers(self) -> dict[tuple, list[str]]:
        """What was said about each question."""
        scene = bpy.context.scene
        scene.collection.objects.link(bpy.data.objects.new("probe", self.mesh))
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        camera.location.z = 3
        scene.collection.objects.link(camera)
        scene.camera = camera
        scene.render.resolution_x = scene.render.resolution_y = 8
        found: dict[tuple, list[str]] = {key: [] for key in self.keys.values()}

        def note(owner: str, message: str) -> None:
            if owner in self.keys:
                found[self.keys[owner]].append(re.sub(r"^node '[^']*' \([^)]*\): ", "", message))

        context = export_scene(bpy.context.evaluated_depsgraph_get(), Options(samples=1), ["Combined"], camera, lambda: False, lambda step: None)
        for owner, message in context.warnings:
            note(owner, message)
        session = ajar.Session()
        session.start(context.description)
        session.wait(600)
        error = session.take_error()
        if error:
            raise RuntimeError(error)
        for diagnostic in session.diagnostics():
            note(diagnostic.object, diagnostic.message)
        return found


def named_in_sources() -> set[str]:
    """Every string constant of the compiler and the exporter."""
    names: set[str] = set()
    files = [*(ROOT / "core" / "shading").rglob("*.cpp"), *(ROOT / "core" / "shading").rglob("*.h"), *(ROOT / "python_addon" / "export").glob("*.py")]
    for file in files:
        names.update(re.findall(r'"([^"\n]+)"', file.read_text(encoding="utf-8")))
    return names


def is_named(name: str, names: set[str]) -> bool:
    return name in names or name in INTERNAL or any(name == prefix + suffix for prefix in ("A_", "B_") for suffix in ("Color", "Vector", "Float"))


def verdict(type_: str, messages: list[str]) -> str:
    missing = [m for m in messages if "not supported" in m]
    if missing:
        return "missing: " + "; ".join(dict.fromkeys(missing))
    said = [*dict.fromkeys(messages)]
    if type_ in APPROXIMATED:
        said.append(APPROXIMATED[type_])
    return "approximated: " + "; ".join(said) if said else "exact"


def rows() -> list[tuple[str, str, str]]:
    types, names = node_types(), named_in_sources()
    probes, probe_tree = Probes(), bpy.data.materials.new("choices")
    probe_tree.use_nodes = True
    settings: dict[str, list] = {}
    sockets: dict[str, list[str]] = {}
    for type_ in types:
        node = probe_tree.node_tree.nodes.new(type_)
        inputs = [s.identifier for s in node.inputs if s.identifier]
        switches = [p.identifier for p in node.bl_rna.properties
                    if p.identifier not in COMMON and p.type in ("BOOLEAN", "INT", "FLOAT") and not p.is_readonly]
        sockets[type_] = [name for name in dict.fromkeys(inputs + switches) if not is_named(name, names)]
        settings[type_] = [None, *choices(node)]
        for choice in settings[type_]:
            for output in node.outputs:
                probes.ask(type_, choice, output.identifier)
    answers = probes.answers()

    table = []
    for type_ in types:
        plain = {output: verdict(type_, said) for (t, choice, output), said in answers.items() if t == type_ and choice is None}
        if not plain:
            continue
        common = next(iter(plain.values())) if len(set(plain.values())) == 1 else "exact"
        details = [f"output {output}: {v}" for output, v in plain.items() if v != common]
        chosen: dict[str, str] = {}
        for (t, choice, output), said in answers.items():
            if t != type_ or choice is None:
                continue
            v = verdict(type_, said)
            if (type_, *choice) in APPROXIMATED:
                v = "approximated: " + APPROXIMATED[(type_, *choice)]
            if v not in plain.values():
                chosen[f"{choice[0]} {choice[1]}"] = v
        details += [f"{name}: {v}" for name, v in chosen.items()]
        if sockets[type_] and not common.startswith("missing"):
            details.append("ignored: " + ", ".join(sockets[type_]))
        state, _, why = common.partition(": ")
        table.append((type_.removeprefix("ShaderNode"), state, "; ".join(filter(None, [why, *details]))))
    return table


def main(path: str) -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    properties.register()
    table = rows()
    count = {state: sum(1 for _, s, _ in table if s == state) for state in ("exact", "approximated", "missing")}
    lines = [
        "# What Ajar makes of Blender's shader nodes", "",
        f"Written by `tools/write_coverage.py` from Blender {bpy.app.version_string}: every node, output and choice was exported and compiled, and what",
        "the compiler reported is repeated here. *Exact* means Cycles' own definition (tests/core/node_values.txt holds recorded values); *missing*",
        "means that a fallback is rendered and the artist is told so by name.", "",
        f"{len(table)} node types: {count['exact']} exact, {count['approximated']} approximated, {count['missing']} missing.", "",
        "| node | state | but |", "|---|---|---|", *(f"| {name} | {state} | {why.replace('|', '/')} |" for name, state, why in table), ""]
    Path(path).write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--") + 1])
