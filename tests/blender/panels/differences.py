"""Properties that the panels of Cycles show and those of Ajar do not, each with its replacement or the reason for its absence.

`test_panels.py` fails for a property that is in neither list.
"""

# Properties of Cycles' add-on, or of Blender for only Cycles, and the property that Ajar shows instead, in the same tab.
REPLACED = {
    ("CyclesRenderSettings", "samples"): ("AjarSceneSettings", "samples"),
    ("CyclesRenderSettings", "preview_samples"): ("AjarSceneSettings", "viewport_samples"),
    ("CyclesRenderSettings", "time_limit"): ("AjarSceneSettings", "time_limit"),
    ("CyclesRenderSettings", "seed"): ("AjarSceneSettings", "seed"),
    ("CyclesRenderSettings", "use_adaptive_sampling"): ("AjarSceneSettings", "image"),
    ("CyclesRenderSettings", "adaptive_threshold"): ("AjarSceneSettings", "noise_level"),
    ("CyclesRenderSettings", "use_guiding"): ("AjarSceneSettings", "integrator"),
    ("CyclesRenderSettings", "max_bounces"): ("AjarSceneSettings", "bounces_total"),
    ("CyclesRenderSettings", "diffuse_bounces"): ("AjarSceneSettings", "bounces_diffuse"),
    ("CyclesRenderSettings", "glossy_bounces"): ("AjarSceneSettings", "bounces_glossy"),
    ("CyclesRenderSettings", "transmission_bounces"): ("AjarSceneSettings", "bounces_transmission"),
    ("CyclesRenderSettings", "volume_bounces"): ("AjarSceneSettings", "bounces_volume"),
    ("CyclesRenderSettings", "transparent_max_bounces"): ("AjarSceneSettings", "bounces_transparent"),
    ("CyclesRenderSettings", "sample_clamp_direct"): ("AjarSceneSettings", "clamp_direct"),
    ("CyclesRenderSettings", "sample_clamp_indirect"): ("AjarSceneSettings", "clamp_indirect"),
    ("CyclesRenderSettings", "caustics_reflective"): ("AjarSceneSettings", "reflective_caustics"),
    ("CyclesRenderSettings", "caustics_refractive"): ("AjarSceneSettings", "refractive_caustics"),
    ("CyclesRenderSettings", "film_exposure"): ("AjarSceneSettings", "exposure"),
    ("CyclesRenderSettings", "pixel_filter_type"): ("AjarSceneSettings", "filter"),
    ("CyclesRenderSettings", "filter_width"): ("AjarSceneSettings", "filter_width"),
    ("CyclesRenderSettings", "motion_blur_position"): ("AjarSceneSettings", "motion_blur_position"),
    ("CyclesCurveRenderSettings", "shape"): ("AjarSceneSettings", "curve_shape"),
    ("CyclesCurveRenderSettings", "subdivisions"): ("AjarSceneSettings", "curve_subdivisions"),
    ("CyclesLightSettings", "cast_shadow"): ("AjarLightSettings", "cast_shadow"),
    ("CyclesLightSettings", "is_portal"): ("AjarLightSettings", "is_portal"),
    ("CyclesLightSettings", "use_multiple_importance_sampling"): ("AjarLightSettings", "use_multiple_importance_sampling"),
    ("CyclesMaterialSettings", "displacement_method"): ("AjarMaterialSettings", "displacement_method"),
    ("CyclesObjectSettings", "use_motion_blur"): ("AjarObjectSettings", "use_motion_blur"),
    ("CyclesObjectSettings", "use_deform_motion"): ("AjarObjectSettings", "use_deform_motion"),
    ("CyclesObjectSettings", "motion_steps"): ("AjarObjectSettings", "motion_steps"),
    ("CyclesObjectSettings", "shadow_terminator_geometry_offset"): ("AjarObjectSettings", "shadow_terminator_geometry_offset"),
    **{("CyclesVisibilitySettings", name): ("AjarWorldSettings", f"visible_{'volume_scatter' if name == 'scatter' else name}")
       for name in ("camera", "diffuse", "glossy", "transmission", "scatter")},
    **{("CyclesCameraSettings", name): ("AjarCameraSettings", name)
       for name in ("panorama_type", "fisheye_fov", "fisheye_lens", "latitude_min", "latitude_max", "longitude_min", "longitude_max",
                    *(f"fisheye_polynomial_k{i}" for i in range(5)))},
    **{("CyclesRenderSettings", name): ("AjarSceneSettings", name)
       for name in ("dicing_rate", "preview_dicing_rate", "max_subdivisions", "dicing_camera", "offscreen_dicing_scale")},
    ("CyclesObjectSettings", "use_adaptive_subdivision"): ("AjarObjectSettings", "use_adaptive_subdivision"),
    ("CyclesObjectSettings", "dicing_rate"): ("AjarObjectSettings", "dicing_rate"),
    **{("CyclesRenderSettings", name): ("AjarSceneSettings", name) for name in ("use_camera_cull", "camera_cull_margin", "use_distance_cull", "distance_cull_margin")},
    **{("CyclesObjectSettings", name): ("AjarObjectSettings", name) for name in ("use_camera_cull", "use_distance_cull")},
    **{("CyclesRenderSettings", name): ("AjarSceneSettings", name) for name in ("rolling_shutter_type", "rolling_shutter_duration")},
    **{("CyclesRenderSettings", name): ("AjarSceneSettings", name) for name in ("texture_limit", "texture_limit_render", "texture_resolution", "texture_resolution_render")},
    ("CyclesRenderLayerSettings", "pass_render_time"): ("AjarViewLayerSettings", "use_pass_render_time"),
    ("CyclesRenderSettings", "film_transparent_glass"): ("AjarSceneSettings", "transparent_glass"),
    ("CyclesRenderSettings", "film_transparent_roughness"): ("AjarSceneSettings", "transparent_glass_roughness"),
    **{("CyclesMaterialSettings", name): ("AjarMaterialSettings", name) for name in ("use_transparent_shadow", "use_bump_map_correction")},
    ("CyclesLightSettings", "max_bounces"): ("AjarLightSettings", "max_bounces"),
    ("CyclesWorldSettings", "max_bounces"): ("AjarWorldSettings", "max_bounces"),
    ("CyclesRenderLayerSettings", "use_pass_shadow_catcher"): ("AjarViewLayerSettings", "use_pass_shadow_catcher"),
    ("CyclesRenderLayerSettings", "use_pass_volume_direct"): ("AjarViewLayerSettings", "use_pass_volume_direct"),
    ("CyclesRenderLayerSettings", "use_pass_volume_indirect"): ("AjarViewLayerSettings", "use_pass_volume_indirect"),
    ("CyclesRenderSettings", "bake_type"): ("AjarSceneSettings", "bake_type"),
    ("CyclesRenderLayerSettings", "pass_debug_sample_count"): ("AjarViewLayerSettings", "use_pass_sample_count"),
    ("CyclesRenderLayerSettings", "denoising_store_passes"): ("AjarViewLayerSettings", "use_pass_denoising"),
}

REPORTED = "not supported yet; python_addon/unsupported.py reports it"
NOISE = "changes the noise of Cycles, not its expected image"
DEVICE = "affects the speed and memory of the devices of Cycles"
DENOISER = "setting of the denoiser of Cycles; Ajar's denoiser has one switch for renders and one for the view"
MULTIRES = "the baking of multiresolution modifiers is an operator of Blender and has no engine"
STEPS = "setting of the ray marching of Cycles; Ajar samples volumes without steps"
VOLUMES = "not read: grids keep their values with 32 bits, and do not blur by their velocity"
MNEE = "setting of the shadow caustics of Cycles; Ajar finds caustics without marked objects"

ABSENT = {
    **{("CyclesRenderSettings", name): REPORTED for name in (
        "use_fast_gi", "fast_gi_method", "ao_bounces", "ao_bounces_render", "sample_offset", "use_sample_subset", "sample_subset_length",
        "blur_glossy")},
    **{("CyclesRenderSettings", name): NOISE for name in (
        "adaptive_min_samples", "use_preview_adaptive_sampling", "preview_adaptive_threshold", "preview_adaptive_min_samples", "sampling_pattern",
        "auto_scrambling_distance", "scrambling_distance", "preview_scrambling_distance", "light_sampling_threshold", "min_light_bounces",
        "min_transparent_bounces", "use_animated_seed", "use_light_tree", "direct_light_sampling_type", "use_surface_guiding", "use_volume_guiding",
        "guiding_training_samples", "use_layer_samples", "use_deterministic_guiding")},
    **{("CyclesRenderSettings", name): DEVICE for name in (
        "device", "feature_set", "shading_system", "use_auto_tile", "tile_size", "debug_use_spatial_splits", "debug_use_compact_bvh", "debug_use_hair_bvh",
        "debug_bvh_time_steps", "debug_bvh_type", "preview_pause")},
    **{("CyclesRenderSettings", name): DENOISER for name in (
        "use_denoising", "denoiser", "denoising_input_passes", "denoising_prefilter", "denoising_quality", "denoising_use_gpu", "use_preview_denoising",
        "preview_denoiser", "preview_denoising_input_passes", "preview_denoising_prefilter", "preview_denoising_quality", "preview_denoising_start_sample",
        "preview_denoising_use_gpu")},
    **{("CyclesRenderSettings", name): STEPS for name in ("volume_step_rate", "volume_preview_step_rate", "volume_max_steps", "volume_biased")},
    **{("template_ID", f"{name}_collection"): "Blender shows light linking for every engine since 4.3; Ajar has panels of its own before" for name in ("receiver", "blocker")},
    ("CyclesMaterialSettings", "sample_as_light"): NOISE,
    ("CyclesMaterialSettings", "emission_sampling"): NOISE,
    **{("CyclesMaterialSettings", name): STEPS for name in ("homogeneous_volume", "volume_sampling", "volume_interpolation", "volume_step_rate")},
    **{("CyclesWorldSettings", name): STEPS for name in ("homogeneous_volume", "volume_sampling", "volume_interpolation", "volume_step_size")},
    **{("CyclesWorldSettings", name): NOISE for name in ("sampling_method", "sample_map_resolution")},
    ("CyclesWorldSettings", "use_shadows"): REPORTED,
    ("CyclesWorldSettings", "is_caustics_light"): MNEE,
    ("CyclesVisibilitySettings", "shadow"): "a world does not block light",
    ("CyclesLightSettings", "is_caustics_light"): MNEE,
    ("CyclesObjectSettings", "is_caustics_caster"): MNEE,
    ("CyclesObjectSettings", "is_caustics_receiver"): MNEE,
    ("CyclesObjectSettings", "ao_distance"): "setting of Fast GI, which is reported",
    ("CyclesObjectSettings", "shadow_terminator_offset"): REPORTED,
    ("CyclesRenderSettings", "use_pixel_jitter"): "setting for debugging Cycles",
    ("CyclesRenderLayerSettings", "denoising_pass_follow_reflections"): "Denoising Data always follows reflections",
    ("CyclesRenderLayerSettings", "denoising_pass_use_albedo_roughness_weighting"): "detail of Cycles' Denoising Data",
    **{("CyclesRenderLayerSettings", name): REPORTED for name in (
        "use_pass_volume_scatter", "use_pass_volume_transmit", "use_pass_volume_majorant")},
    ("CyclesRenderLayerSettings", "use_denoising"): DENOISER,
    **{("ViewLayer", name): REPORTED for name in (
        "use_pass_shadow", "use_pass_subsurface_direct", "use_pass_subsurface_indirect", "use_pass_subsurface_color", "use_pass_grease_pencil")},
    ("ViewLayer", "use_pass_cryptomatte_accurate"): "setting of Eevee",
    **{("Object", f"shadow_terminator_{name}_offset"): REPORTED for name in ("shading", "normal")},
    ("RenderSettings", "preview_pixel_size"): "views of Ajar always begin with large pixels",
    ("RenderSettings", "hair_type"): "setting of Eevee",
    ("RenderSettings", "hair_subdiv"): "setting of Eevee",
    **{("RenderSettings", name): MULTIRES for name in ("use_bake_multires", "bake_type", "bake_margin", "use_bake_clear", "use_bake_lores_mesh", "bake_margin_type")},
    **{("BakeSettings", name): MULTIRES for name in ("use_multires", "type", "use_lores_mesh", "displacement_space")},
    ("WorldLighting", "ao_factor"): "setting of Fast GI, which is reported",
    ("WorldLighting", "distance"): "setting of Fast GI, which is reported",
    **{("Volume", name): VOLUMES for name in ("velocity_grid", "velocity_scale", "velocity_unit")},
    **{("VolumeRender", name): VOLUMES for name in ("clipping", "precision", "step_size")},
}
ABSENT_STRUCTS: dict[str, str] = {}

PASSES = {
    "Debug Sample Count": "replaced by Sample Count, which has the number of samples and not a fraction",
    "Noisy Image": "exists when Ajar's own denoiser runs; the switch of Cycles does not start it",
}

# Properties of others that only the panels of Ajar show.
ADDED = {
    ("Light", "use_nodes"): "switches nodes on; Cycles has an operator for this",
    ("World", "use_nodes"): "switches nodes on; Cycles has an operator for this",
    ("Material", "use_nodes"): "switches nodes on; Cycles has an operator for this",
    ("RenderSettings", "compositor_precision"): "Cycles hides it while the compositor runs on the processor",
    ("template_preview", "AreaLight"): "portals have no preview with Cycles",
    ("template_node_view", "Surface"): "the nodes of a portal, which Cycles hides",
}

# Outside of Properties: what only the panels of one engine show, and operators that can be called with only one engine.
ABSENT_IN_EDITORS = {
    ("CyclesView3DShadingSettings", "render_pass"): "rendered views show only the combined image; renders have the passes",
    ("View3DShading", "use_scene_lights_render"): "rendered views always use the lamps of the scene",
    ("View3DShading", "use_scene_world_render"): "rendered views always use the world of the scene",
    ("CyclesRenderSettings", "preview_pause"): "Ajar has an operator for it: ajar.pause_views",
}
ADDED_IN_EDITORS = {
    ("World", "lightgroup"): "Cycles shows it only in Properties",
    ("operator", "scene.view_layer_add_lightgroup"): "the button next to this property",
    ("scene.view_layer_add_lightgroup", "name = "): "the button next to this property",
    ("AjarSceneSettings", "hint_collection"): "light hints",
}
OPERATORS = {
    "*_button*": "operators of the button below the mouse, which differs in Properties",
    "screen.a*": "operators of a border of an area near the mouse",
}
