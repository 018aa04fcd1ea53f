"""How Ajar treats every setting of Blender and Cycles, every part of a shader node and every pass: it is read, reported, or has no meaning for Ajar.
`differences.py` lists what the panels of Cycles show and those of Ajar do not; this list includes it.

Names may end in `*`. The list excludes read-only properties and those of every datablock (name, library, users ...).

`inventory.tsv` lists each of them by its full name, for each Blender, with the results of the probes. `tools/coverage/write_inventory.py` writes it
and defines its words. `test_inventory.py` fails if a Blender has something that the table does not list.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

import differences

BLENDER = "Blender applies it for every engine"
VIEW = "setting of the display in views, not of renders"
ANIMATION = "setting of animation, simulation or rigging; Ajar reads their result"
EDITING = "setting of editing, selecting or painting"
EEVEE = "setting of Eevee"
OUTPUT = "setting of the output of images"
POINTER = "refers to settings that have their own list"
DEBUG = "setting for debugging Cycles"

READ = {
    "Scene": "camera world cycles cycles_curves render frame_current frame_subframe frame_float",
    "RenderSettings": "use_texture_cache use_auto_generate_texture_cache resolution_x resolution_y resolution_percentage pixel_aspect_x pixel_aspect_y film_transparent threads threads_mode use_motion_blur use_persistent_data "
                      "motion_blur_shutter motion_blur_shutter_curve motion_blur_position use_border border_* use_crop_to_border engine use_simplify use_multiview views_format",
    "ViewLayer": "material_override world_override samples lightgroups active_lightgroup* use_solid use_sky use_strand use_motion_blur use use_pass_combined use_pass_z "
                 "use_pass_position use_pass_normal use_pass_uv use_pass_mist use_pass_object_index use_pass_material_index use_pass_emit use_pass_environment "
                 "use_pass_diffuse_* use_pass_glossy_* use_pass_transmission_* use_pass_vector use_pass_ambient_occlusion use_pass_cryptomatte_object "
                 "use_pass_cryptomatte_material use_pass_cryptomatte_asset pass_cryptomatte_depth pass_alpha_threshold aovs active_aov* cycles",
    "Object": "data parent active_material location rotation_* scale delta_* matrix_* instance_* use_instance_* show_instancer_for_* visible_* is_holdout pass_index color "
              "hide_render hide_viewport lightgroup cycles is_shadow_catcher light_linking shadow_terminator_geometry_offset modifiers particle_systems dimensions",
    "Mesh": "use_auto_smooth auto_smooth_angle use_auto_texspace auto_texspace texspace_* cycles",
    "Curves": "surface surface_uv_map",
    "*Light": "type color energy shadow_soft_size angle shape size size_y spread spot_size spot_blend use_nodes node_tree cycles use_shadow use_temperature temperature exposure normalize use_soft_falloff",
    "CyclesRenderSettings": "use_layer_samples",
    "World": "color use_nodes node_tree mist_settings lightgroup cycles cycles_visibility",
    "WorldMistSettings": "start depth falloff",
    "Camera": "type sensor_* angle* clip_start clip_end lens ortho_scale shift_x shift_y dof stereo cycles panorama_type fisheye_* latitude_* longitude_*",
    "CameraDOFSettings": "*",
    "Material": "use_nodes node_tree diffuse_color pass_index displacement_method use_transparent_shadow cycles",
}
REPORTED = {
    "Camera": "custom_* cycles_custom central_cylindrical_*",
    "ViewLayer": "use_pass_subsurface_*",
}
NO_MEANING = {
    "Scene": {
        ANIMATION: "frame_* use_preview_range show_subframe show_keys_from_selected_only lock_frame_selection_to_range animation_data sync_mode rigidbody_world gravity use_gravity "
                   "time_jump_* allow_preroll use_custom_simulation_range simulation_frame_* playback_loop_mode",
        EDITING: "background_set tool_settings unit_settings cursor grease_pencil annotation active_clip grease_pencil_settings use_stamp_note",
        BLENDER: "use_audio* audio_* sequence_editor node_tree use_nodes compositing_node_group view_settings display_settings sequencer_colorspace_settings collection",
        VIEW: "safe_areas display hydra",
        EEVEE: "eevee",
    },
    "RenderSettings": {
        OUTPUT: "image_settings ffmpeg fps fps_base frame_map_* dither_intensity use_placeholder use_overwrite use_file_extension filepath use_render_cache use_stamp* stamp_* "
                "metadata_input ppm_* save_output",
        BLENDER: "use_compositing use_sequencer* sequencer_* use_lock_interface use_single_layer use_freestyle line_thickness* simplify_* use_simplify_normals compositor_*",
        EEVEE: "filter_size hair_type hair_subdiv use_high_quality_normals anisotropic_filter",
        "setting of Blender's bake operators": "bake* use_bake*",
        "views always begin with large pixels": "preview_pixel_size",
    },
    "ViewLayer": {
        EEVEE: "eevee use_ao use_pass_cryptomatte_accurate", BLENDER: "layer_collection active_layer_collection use_freestyle freestyle_settings depsgraph use_grease_pencil",
        "setting of volume objects, which are reported": "use_volumes",
    },
    "Object": {
        ANIMATION: "parent_* use_camera_lock_parent track_axis up_axis lock_* field collision soft_body rigid_body* pose* animation_* motion_path use_parent_final_indices "
                   "use_simulation_cache add_rest_position_attribute active_shape_key* show_only_shape_key use_shape_key_edit_mode",
        VIEW: "empty_* image_user show_* use_empty_image_alpha display* use_grease_pencil_lights hide_select hide_surface_pick lineart",
        EDITING: "use_mesh_mirror_* active_material_index active_selection_set", EEVEE: "hide_probe_*",
        "setting of the rays of the Raycast node, which is reported": "visible_raycast", "changes the shadow terminator of Cycles": "shadow_terminator_normal_offset",
    },
    "Mesh": {EDITING: "texture_mesh uv_layer_* remesh_* use_remesh_* use_mirror_* texco_mesh use_paint_* radial_symmetry", ANIMATION: "shape_keys animation_data"},
    "Curves": {EDITING: "use_mirror_* selection_domain use_sculpt_* surface_collision_distance", ANIMATION: "animation_data"},
    "*Light": {
        EEVEE: "distance specular_factor diffuse_factor volume_factor transmission_factor use_custom_distance cutoff_distance falloff_* linear_* quadratic_* constant_coefficient "
               "shadow_buffer_* shadow_color use_contact_shadow contact_shadow_* shadow_cascade_* shadow_filter_radius shadow_maximum_resolution use_shadow_jitter shadow_jitter_overblur "
               "use_absolute_resolution",
        VIEW: "show_cone use_square", ANIMATION: "animation_data",
    },
    "World": {EEVEE: "use_eevee_finite_volume probe_resolution sun_* use_sun_*", ANIMATION: "animation_data", "setting of Fast GI, which is reported": "light_settings"},
    "WorldMistSettings": {"setting of Blender Internal; Cycles does not read it": "use_mist intensity height"},
    "Camera": {VIEW: "passepartout_alpha display_size show_* composition_guide_color background_images", EDITING: "lens_unit", ANIMATION: "animation_data"},
    "Material": {
        EEVEE: "blend_method shadow_method alpha_threshold show_transparent_back use_backface_culling* use_screen_refraction use_sss_translucency refraction_depth surface_render_method "
               "use_transparency_overlap use_raytrace_refraction thickness_mode use_thickness_from_shadow volume_intersection_method max_vertex_displacement",
        VIEW: "preview_render_type use_preview_world specular_color roughness specular_intensity metallic grease_pencil lineart",
        EDITING: "paint_* texture_paint_*", BLENDER: "line_color line_priority", ANIMATION: "animation_data",
    },
    "CyclesRenderSettings": {DEBUG: "debug_*", differences.NOISE: "use_guiding guiding_* surface_guiding_probability volume_guiding_probability use_guiding_*"},
}

# Parts of shader nodes that the probes do not change: properties with names and datablocks, and nodes without outputs to link.
READ_OF_NODES = {
    "ShaderNodeOutputMaterial": "target; input Surface; input Volume; input Displacement",
    "ShaderNodeOutputWorld": "target; input Surface; input Volume",
    "ShaderNodeOutputLight": "target; input Surface",
    "ShaderNodeGroup": "node_tree; interface",
    "NodeGroup*": "interface",
    "NodeReroute": "input *; output *",
    "ShaderNode*": "image; image_user; mapping; color_ramp; attribute_name; layer_name; uv_map; ies; filepath",
    "ShaderNodeTexCoord": "object",
    "ShaderNodeOutputAOV": "*",
}
REPORTED_OF_NODES = {
    "ShaderNodeScript": "*", "ShaderNodeTexPointDensity": "*", "ShaderNodeRaycast": "*",
}
NO_MEANING_OF_NODES = {
    "ShaderNodeMix": {"setting of geometry nodes, which shader nodes do not have": "output Result_Rotation; data_type"},
    "ShaderNodeOutputMaterial": {EEVEE: "input Thickness"},
    "ShaderNodeOutputLineStyle": {BLENDER: "*"},
    "NodeFrame": {EDITING: "*"},
    "NodeReroute": {EDITING: "socket_idname"},
    "ShaderNodeTex*": {"setting of Blender Internal; Cycles does not read it": "color_mapping"},
}
PASSES = {
    "read": {"Combined", "Depth", "Mist", "Position", "Normal", "UV", "IndexOB", "IndexMA", "Object Index", "Material Index", "DiffDir", "DiffInd", "DiffCol", "GlossDir", "GlossInd", "GlossCol",
             "TransDir", "TransInd", "TransCol", "VolumeDir", "VolumeInd", "Emit", "Env", "Emission", "Environment", "Debug Sample Count", "Render Time", "Noisy Image", "Vector", "AO", "Ambient Occlusion", "CryptoObject", "CryptoMaterial", "CryptoAsset",
             *(f"{kind} {part}" for kind in ("Diffuse", "Glossy", "Transmission") for part in ("Direct", "Indirect", "Color")), "Volume Direct", "Volume Indirect"},
    "reported": {"Shadow", "Shadow Catcher", "Noisy Shadow Catcher", "SubsurfaceDir", "SubsurfaceInd", "SubsurfaceCol", "Volume Scatter", "Volume Transmit",
                 "Volume Majorant",
                 *(f"Denoising {name}" for name in ("Normal", "Albedo", "Depth", "Specular Albedo", "Roughness"))},
}
TABLE = Path(__file__).with_name("inventory.tsv")


@dataclass(frozen=True)
class Row:
    thing: str
    choices: tuple[str, ...]
    states: dict[str, str]   # key: the first two numbers of the version of Blender
    reason: str


def _lists(name: str, text: str) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in text.split())


def fate(struct: str, name: str) -> str:
    """"read", "reported", the reason why it has no meaning, or "" if it is in no list."""
    if (struct, name) in differences.REPLACED:
        return "read"
    if (struct, name) in differences.ABSENT:
        return differences.ABSENT[struct, name]
    for status, table in (("read", READ), ("reported", REPORTED)):
        if any(fnmatchcase(struct, kind) and _lists(name, text) for kind, text in table.items()):
            return status
    for kind, reasons in NO_MEANING.items():
        if fnmatchcase(struct, kind):
            for reason, text in reasons.items():
                if _lists(name, text):
                    return reason
    return ""


def _fate_of_node(node: str, part: str) -> str:
    def lists(text: str) -> bool:
        return any(fnmatchcase(part, pattern) for pattern in text.split("; "))
    for status, table in (("read", READ_OF_NODES), ("reported", REPORTED_OF_NODES)):
        if any(fnmatchcase(node, kind) and lists(text) for kind, text in table.items()):
            return status
    return next((reason for kind, reasons in NO_MEANING_OF_NODES.items() if fnmatchcase(node, kind) for reason, text in reasons.items() if lists(text)), "")


def fate_of(thing: str) -> str:
    """The result of `fate` for a setting, a part of a node or a pass, by its name in things.py. Of nodes, only for the parts that the probes do not change."""
    if thing.startswith("pass "):
        return next((status for status, names in PASSES.items() if thing.removeprefix("pass ") in names), "")
    owner, name = thing.split(" ", 1) if " " in thing.split(".")[0] else thing.split(".", 1)
    return _fate_of_node(owner, name) if owner.startswith(("ShaderNode", "Node")) else fate(owner, name)


def state_of(fate: str) -> str:
    """The word of the table for a result of `fate`."""
    if fate in ("read", "reported", ""):
        return fate
    return "reported" if "reported" in fate or "not supported" in fate else "none"


def relevant(things: dict[str, list[str]]) -> dict[str, list[str]]:
    """Removes the choices of settings that Ajar does not read, and of settings that depend on the machine."""
    def chosen(thing: str) -> bool:
        return thing.startswith("ShaderNode") or (thing not in ("RenderSettings.engine", "RenderSettings.views_format") and state_of(fate_of(thing)) in ("read", "reported"))
    return {thing: choices if chosen(thing) else [] for thing, choices in things.items()}


def series(blender: str) -> str:
    return ".".join(blender.split()[0].split(".")[:2])


def rows() -> list[Row]:
    with open(TABLE, encoding="utf-8", newline="") as file:
        _, _, *blenders, _ = next(reader := csv.reader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
        return [Row(line[0], tuple(line[1].split()), dict(zip(blenders, line[2:-1])), line[-1]) for line in reader]
