// SceneDescription: geometry in bulk by NumPy arrays, everything else field by field.
//
// `add_*` return the index that other parts refer to. Lists read from a description are copies.
#include "arrays.h"
#include "bind.h"
#include "description/archive.h"
#include "geometry/mesh_analysis.h"
#include "description/scene_description.h"

namespace ajar::python {
namespace {

using OptionalFloats = std::optional<Floats>;
using Rows = std::array<float, 12>;

int index_of_last(size_t size) { return static_cast<int>(size) - 1; }


MeshDescription read_mesh(const std::string& name, const Floats& positions, const Array<uint32_t>& triangles,
                          const std::optional<Array<uint16_t>>& material_slots, const OptionalFloats& normals, Domain normal_domain,
                          const std::vector<py::tuple>& attributes, const std::string& active_uv, Vec3 texture_space_location,
                          Vec3 texture_space_size) {
  const std::string of = " of mesh \"" + name + "\"";
  MeshDescription mesh;
  mesh.name = name;
  mesh.positions = copy_rows<Vec3>(positions, "positions" + of);
  mesh.triangles = copy_rows<UVec3>(triangles, "triangles" + of);
  if (material_slots) mesh.material_slots = copy_rows<uint16_t>(*material_slots, "material_slots" + of);
  if (normals) mesh.normals = copy_rows<Vec3>(*normals, "normals" + of);
  mesh.normal_domain = normal_domain;
  for (const py::tuple& item : attributes) {
    if (item.size() != 3) throw py::value_error("attributes" + of + " must be tuples (name, domain, values[n, components])");
    const auto values = item[2].cast<Floats>();
    Attribute attribute;
    attribute.name = item[0].cast<std::string>();
    attribute.domain = item[1].cast<Domain>();
    attribute.components = values.ndim() == 2 ? int(values.shape(1)) : 1;
    if (attribute.components < 1 || attribute.components > 4)
      throw py::value_error("attribute \"" + attribute.name + "\"" + of + " must have 1 to 4 components, not " + shape_text(values));
    attribute.values = copy_numbers(values);
    mesh.attributes.push_back(std::move(attribute));
  }
  mesh.active_uv = active_uv;
  mesh.texture_space_location = texture_space_location;
  mesh.texture_space_size = texture_space_size;
  return mesh;
}

std::shared_ptr<MeshDescription> make_strands(const std::string& name, const Floats& positions, const Floats& radii, const Array<uint32_t>& strands,
                                              const std::optional<Array<uint16_t>>& material_slots, const std::vector<py::tuple>& attributes,
                                              const std::string& active_uv, Vec3 texture_space_location, Vec3 texture_space_size, StrandShape shape,
                                              int subdivisions) {
  auto mesh = std::make_shared<MeshDescription>(read_mesh(name, positions, Array<uint32_t>(), material_slots, std::nullopt, Domain::Vertex, attributes,
                                                          active_uv, texture_space_location, texture_space_size));
  mesh->radii = copy_rows<float>(radii, "radii of strands \"" + name + "\"");
  mesh->strands = copy_rows<uint32_t>(strands, "strands of \"" + name + "\"");
  mesh->strand_shape = shape;
  mesh->strand_subdivisions = subdivisions;
  return mesh;
}

template <class... Arguments>
int add_mesh(SceneDescription& description, const Arguments&... arguments) {
  description.meshes.push_back(read_mesh(arguments...));
  return index_of_last(description.meshes.size());
}

template <class... Arguments>
std::shared_ptr<MeshDescription> make_mesh(const Arguments&... arguments) {
  return std::make_shared<MeshDescription>(read_mesh(arguments...));
}

int add_shared_mesh(SceneDescription& description, const std::shared_ptr<MeshDescription>& mesh) {
  description.meshes.emplace_back();
  description.meshes.back().shared = mesh;
  return index_of_last(description.meshes.size());
}

std::vector<MeshDescription> meshes_of(const SceneDescription& description) {
  std::vector<MeshDescription> meshes;
  for (const MeshDescription& mesh : description.meshes) meshes.push_back(mesh.shared ? *mesh.shared : mesh);
  return meshes;
}

/// Define `function`, whose last arguments are those of make_strands.
template <class Target, class Function>
void def_strands(Target& target, const char* name, Function function, const char* text) {
  target.def(name, function, py::kw_only(), py::arg("name"), py::arg("positions"), py::arg("radii"), py::arg("strands"),
             py::arg("material_slots") = py::none(), py::arg("attributes") = std::vector<py::tuple>{}, py::arg("active_uv") = "",
             py::arg("texture_space_location") = Vec3(0.0f), py::arg("texture_space_size") = Vec3(1.0f), py::arg("shape") = StrandShape::Ribbon,
             py::arg("subdivisions") = 2, text);
}
template <class... Arguments>
auto strands_adder(std::shared_ptr<MeshDescription> (*make)(Arguments...)) {
  return [make](SceneDescription& description, Arguments... arguments) {
    description.meshes.push_back(std::move(*make(arguments...)));
    return index_of_last(description.meshes.size());
  };
}

/// Define `function`, whose last arguments are those of read_mesh.
template <class Target, class Function>
void def_mesh(Target& target, const char* name, Function function, const char* text) {
  target.def(name, function, py::kw_only(), py::arg("name"), py::arg("positions"), py::arg("triangles"),
             py::arg("material_slots") = py::none(), py::arg("normals") = py::none(), py::arg("normal_domain") = Domain::Corner,
             py::arg("attributes") = std::vector<py::tuple>{}, py::arg("active_uv") = "",
             py::arg("texture_space_location") = Vec3(0.0f), py::arg("texture_space_size") = Vec3(1.0f), text);
}
using MeshArguments = MeshDescription(const std::string&, const Floats&, const Array<uint32_t>&, const std::optional<Array<uint16_t>>&,
                                      const OptionalFloats&, const Domain&, const std::vector<py::tuple>&, const std::string&,
                                      const Vec3&, const Vec3&);
template <class... Arguments>
auto adder(MeshDescription (*)(const Arguments&...)) { return &add_mesh<Arguments...>; }
template <class... Arguments>
auto maker(MeshDescription (*)(const Arguments&...)) { return &make_mesh<Arguments...>; }

int add_object(SceneDescription& description, const std::string& name, int mesh, const std::vector<int>& materials, uint32_t visibility,
               bool holdout, bool shadow_catcher, int pass_index, Vec4 color, float importance, float shadow_terminator_offset,
               float light_importance, const std::vector<std::tuple<std::string, bool, Vec4>>& properties) {
  description.objects.push_back({name, mesh, materials, visibility, holdout, shadow_catcher, pass_index, color, importance,
                                 shadow_terminator_offset, light_importance, {}});
  for (const auto& [property, of_instancer, value] : properties) description.objects.back().properties.push_back({property, of_instancer, value});
  return index_of_last(description.objects.size());
}

void add_instances(SceneDescription& description, const Array<int32_t>& objects, const Floats& world_from_object,
                   const OptionalFloats& random) {
  const size_t count = check_rows(objects, 1, "objects");
  if (check_rows(world_from_object, 12, "world_from_object") != count)
    throw py::value_error("world_from_object must have one row of 12 per object");
  if (random && check_rows(*random, 1, "random") != count) throw py::value_error("random must have one number per object");
  const int32_t* object = objects.data();
  const float* rows = world_from_object.data();
  const float* randoms = random ? random->data() : nullptr;
  py::gil_scoped_release release;
  description.instances.reserve(description.instances.size() + count);
  for (size_t i = 0; i < count; ++i) {
    InstanceDescription instance;
    instance.object = object[i];
    std::memcpy(instance.world_from_object.data(), rows + 12 * i, sizeof(Rows));
    if (randoms) instance.random = randoms[i];
    description.instances.push_back(instance);
  }
}

/// Keys of instances that move while the shutter is open.
void set_motion(SceneDescription& description, const Array<int32_t>& instances, const Floats& world_from_object) {
  const size_t count = check_rows(instances, 1, "instances");
  const size_t keys = world_from_object.size() / 12;
  if (count == 0) return;
  if (world_from_object.size() % (12 * count) != 0) throw py::value_error("world_from_object must have the same number of rows of 12 for each instance");
  const int each = int(keys / count);
  for (size_t i = 0; i < count; ++i) {
    InstanceDescription& instance = description.instances.at(size_t(instances.data()[i]));
    instance.first_motion_key = int(description.motion_keys.size());
    instance.motion_key_count = each;
    for (int k = 0; k < each; ++k) {
      Rows rows;
      std::memcpy(rows.data(), world_from_object.data() + 12 * (i * size_t(each) + size_t(k)), sizeof(Rows));
      description.motion_keys.push_back(rows);
    }
  }
}

int add_image(SceneDescription& description, const std::string& name, const std::string& path, const py::bytes& packed,
              const OptionalFloats& pixels, int width, int height, const std::string& color_space, AlphaMode alpha_mode) {
  ImageDescription image;
  image.name = name;
  image.path = path;
  const std::string_view bytes = packed;
  image.packed.assign(bytes.begin(), bytes.end());
  if (pixels) {
    if (size_t(pixels->size()) != size_t(width) * height * 4)
      throw py::value_error("pixels of image \"" + name + "\" must be width * height * 4 floats, not " + shape_text(*pixels));
    image.pixels = copy_numbers(*pixels);
  }
  image.width = width;
  image.height = height;
  image.color_space = color_space;
  image.alpha_mode = alpha_mode;
  description.images.push_back(std::move(image));
  return index_of_last(description.images.size());
}

void bind_enums(py::module_& module) {
  py::enum_<AlphaMode>(module, "AlphaMode")
      .value("Straight", AlphaMode::Straight)
      .value("Premultiplied", AlphaMode::Premultiplied)
      .value("ChannelPacked", AlphaMode::ChannelPacked)
      .value("None_", AlphaMode::None);
  py::enum_<Domain>(module, "Domain")
      .value("Vertex", Domain::Vertex)
      .value("Corner", Domain::Corner)
      .value("Face", Domain::Face);
  py::enum_<StrandShape>(module, "StrandShape").value("Ribbon", StrandShape::Ribbon).value("Round", StrandShape::Round);
  py::enum_<LightKind>(module, "LightKind")
      .value("Point", LightKind::Point)
      .value("Spot", LightKind::Spot)
      .value("Sun", LightKind::Sun)
      .value("Area", LightKind::Area);
  py::enum_<AreaShape>(module, "AreaShape").value("Rectangle", AreaShape::Rectangle).value("Ellipse", AreaShape::Ellipse);
  py::enum_<CameraKind>(module, "CameraKind")
      .value("Perspective", CameraKind::Perspective)
      .value("Orthographic", CameraKind::Orthographic)
      .value("Panorama", CameraKind::Panorama);
  py::enum_<PanoramaKind>(module, "PanoramaKind")
      .value("Equirectangular", PanoramaKind::Equirectangular)
      .value("FisheyeEquidistant", PanoramaKind::FisheyeEquidistant)
      .value("FisheyeEquisolid", PanoramaKind::FisheyeEquisolid)
      .value("FisheyePolynomial", PanoramaKind::FisheyePolynomial)
      .value("MirrorBall", PanoramaKind::MirrorBall)
      .value("CubemapFace", PanoramaKind::CubemapFace);
  py::enum_<FilterKind>(module, "FilterKind")
      .value("Box", FilterKind::Box)
      .value("Gaussian", FilterKind::Gaussian)
      .value("BlackmanHarris", FilterKind::BlackmanHarris);
  py::enum_<BumpTerminator>(module, "BumpTerminator", "How light fades where it grazes a bumped surface: as in Blender until 4.4, or since 4.5.")
      .value("Cubic", BumpTerminator::Cubic)
      .value("Microfacet", BumpTerminator::Microfacet);
  module.attr("UNDEFORMED_POSITION") = kUndeformedPosition;
  module.attr("RANDOM_PER_ISLAND") = kRandomPerIsland;
  module.attr("POINTINESS") = kPointiness;
  module.attr("VISIBLE_CAMERA") = int(kVisibleCamera);
  module.attr("VISIBLE_DIFFUSE") = int(kVisibleDiffuse);
  module.attr("VISIBLE_GLOSSY") = int(kVisibleGlossy);
  module.attr("VISIBLE_TRANSMISSION") = int(kVisibleTransmission);
  module.attr("VISIBLE_VOLUME_SCATTER") = int(kVisibleVolumeScatter);
  module.attr("VISIBLE_SHADOW") = int(kVisibleShadow);
  module.attr("VISIBLE_ALL") = int(kVisibleAll);
}

void bind_geometry(py::module_& module) {
  py::class_<Attribute>(module, "Attribute")
      .def_readonly("name", &Attribute::name)
      .def_readonly("domain", &Attribute::domain)
      .def_readonly("components", &Attribute::components)
      .def_property_readonly("values", [](const Attribute& a) { return to_array<float>(a.values, a.components); });
  py::class_<MeshDescription, std::shared_ptr<MeshDescription>>(module, "MeshDescription", "Its arrays are copies.")
      .def_readonly("name", &MeshDescription::name)
      .def_property_readonly("positions", [](const MeshDescription& m) { return to_array<float>(m.positions); })
      .def_property_readonly("triangles", [](const MeshDescription& m) { return to_array<uint32_t>(m.triangles); })
      .def_property_readonly("material_slots", [](const MeshDescription& m) { return to_array<uint16_t>(m.material_slots); })
      .def_property_readonly("normals", [](const MeshDescription& m) { return to_array<float>(m.normals); })
      .def_readonly("normal_domain", &MeshDescription::normal_domain)
      .def_readonly("attributes", &MeshDescription::attributes)
      .def_readonly("active_uv", &MeshDescription::active_uv)
      .def_property_readonly("strands", [](const MeshDescription& m) { return to_array<uint32_t>(m.strands); })
      .def_property_readonly("radii", [](const MeshDescription& m) { return to_array<float>(m.radii); })
      .def_readonly("strand_shape", &MeshDescription::strand_shape)
      .def_readonly("strand_subdivisions", &MeshDescription::strand_subdivisions)
      .def_readonly("texture_space_location", &MeshDescription::texture_space_location)
      .def_readonly("texture_space_size", &MeshDescription::texture_space_size);
  py::class_<ObjectDescription>(module, "ObjectDescription")
      .def_readonly("name", &ObjectDescription::name)
      .def_readonly("mesh", &ObjectDescription::mesh)
      .def_readonly("materials", &ObjectDescription::materials)
      .def_readonly("visibility", &ObjectDescription::visibility)
      .def_readonly("holdout", &ObjectDescription::holdout)
      .def_readonly("shadow_catcher", &ObjectDescription::shadow_catcher)
      .def_readonly("pass_index", &ObjectDescription::pass_index)
      .def_readonly("color", &ObjectDescription::color)
      .def_readonly("importance", &ObjectDescription::importance)
      .def_readonly("shadow_terminator_offset", &ObjectDescription::shadow_terminator_offset)
      .def_readonly("light_importance", &ObjectDescription::light_importance)
      .def_property_readonly("properties", [](const ObjectDescription& o) {
        std::vector<std::tuple<std::string, bool, Vec4>> found;
        for (const ObjectProperty& property : o.properties) found.emplace_back(property.name, property.of_instancer, property.value);
        return found;
      });
  py::class_<InstanceDescription>(module, "InstanceDescription")
      .def_readonly("object", &InstanceDescription::object)
      .def_readonly("world_from_object", &InstanceDescription::world_from_object)
      .def_readonly("motion_key_count", &InstanceDescription::motion_key_count)
      .def_readonly("random", &InstanceDescription::random);
  py::class_<ImageDescription>(module, "ImageDescription")
      .def_readonly("name", &ImageDescription::name)
      .def_readonly("path", &ImageDescription::path)
      .def_property_readonly("packed_size", [](const ImageDescription& i) { return i.packed.size(); })
      .def_property_readonly("pixels", [](const ImageDescription& i) { return to_array<float>(i.pixels, 4); })
      .def_readonly("width", &ImageDescription::width)
      .def_readonly("height", &ImageDescription::height)
      .def_readonly("color_space", &ImageDescription::color_space)
      .def_readonly("alpha_mode", &ImageDescription::alpha_mode);
}

void bind_light_world_camera(py::module_& module) {
  py::class_<LightDescription>(module, "LightDescription")
      .def(py::init<>())
      .def_readwrite("name", &LightDescription::name)
      .def_readwrite("kind", &LightDescription::kind)
      .def_readwrite("world_from_light", &LightDescription::world_from_light)
      .def_readwrite("color", &LightDescription::color)
      .def_readwrite("energy", &LightDescription::energy)
      .def_readwrite("radius", &LightDescription::radius)
      .def_readwrite("spot_angle", &LightDescription::spot_angle)
      .def_readwrite("spot_blend", &LightDescription::spot_blend)
      .def_readwrite("sun_angle", &LightDescription::sun_angle)
      .def_readwrite("area_shape", &LightDescription::area_shape)
      .def_readwrite("area_size", &LightDescription::area_size)
      .def_readwrite("spread", &LightDescription::spread)
      .def_readwrite("graph", &LightDescription::graph)
      .def_readwrite("visibility", &LightDescription::visibility)
      .def_readwrite("cast_shadow", &LightDescription::cast_shadow)
      .def_readwrite("multiple_importance", &LightDescription::multiple_importance)
      .def_readwrite("light_importance", &LightDescription::light_importance);
  py::class_<WorldDescription>(module, "WorldDescription")
      .def_readwrite("name", &WorldDescription::name)
      .def_readwrite("graph", &WorldDescription::graph)
      .def_readwrite("color", &WorldDescription::color)
      .def_readwrite("visibility", &WorldDescription::visibility)
      .def_readwrite("light_importance", &WorldDescription::light_importance);
  py::class_<PanoramaDescription>(module, "PanoramaDescription")
      .def(py::init<>())
      .def("__eq__", [](const PanoramaDescription& a, const PanoramaDescription& b) { return a == b; })
      .def_readwrite("kind", &PanoramaDescription::kind)
      .def_readwrite("limits", &PanoramaDescription::limits)
      .def_readwrite("fisheye_fov", &PanoramaDescription::fisheye_fov)
      .def_readwrite("fisheye_lens", &PanoramaDescription::fisheye_lens)
      .def_readwrite("sensor", &PanoramaDescription::sensor)
      .def_readwrite("polynomial", &PanoramaDescription::polynomial);
  py::class_<CameraDescription>(module, "CameraDescription")
      .def(py::init<>())
      .def("__eq__", [](const CameraDescription& a, const CameraDescription& b) { return a == b; })
      .def_readwrite("name", &CameraDescription::name)
      .def_readwrite("present", &CameraDescription::present)
      .def_readwrite("kind", &CameraDescription::kind)
      .def_readwrite("world_from_camera", &CameraDescription::world_from_camera)
      .def_readwrite("screen_window", &CameraDescription::screen_window)
      .def_readwrite("clip_start", &CameraDescription::clip_start)
      .def_readwrite("clip_end", &CameraDescription::clip_end)
      .def_readwrite("aperture_radius", &CameraDescription::aperture_radius)
      .def_readwrite("focus_distance", &CameraDescription::focus_distance)
      .def_readwrite("blades", &CameraDescription::blades)
      .def_readwrite("blade_rotation", &CameraDescription::blade_rotation)
      .def_readwrite("aperture_ratio", &CameraDescription::aperture_ratio)
      .def_readwrite("panorama", &CameraDescription::panorama)
      .def_readwrite("motion", &CameraDescription::motion)
      .def_readwrite("shutter", &CameraDescription::shutter);
}

void bind_settings(py::module_& module) {
  py::class_<BounceLimits>(module, "BounceLimits")
      .def_readwrite("total", &BounceLimits::total)
      .def_readwrite("diffuse", &BounceLimits::diffuse)
      .def_readwrite("glossy", &BounceLimits::glossy)
      .def_readwrite("transmission", &BounceLimits::transmission)
      .def_readwrite("transparent", &BounceLimits::transparent)
      .def_readwrite("volume", &BounceLimits::volume);
  py::class_<RenderSettings>(module, "RenderSettings")
      .def(py::init<>())
      .def("__copy__", [](const RenderSettings& settings) { return RenderSettings(settings); })
      .def("__eq__", [](const RenderSettings& a, const RenderSettings& b) { return a == b; })
      .def_readwrite("width", &RenderSettings::width)
      .def_readwrite("height", &RenderSettings::height)
      .def_readwrite("region", &RenderSettings::region)
      .def_readwrite("filter", &RenderSettings::filter)
      .def_readwrite("filter_width", &RenderSettings::filter_width)
      .def_readwrite("exposure", &RenderSettings::exposure)
      .def_readwrite("transparent_film", &RenderSettings::transparent_film)
      .def_readwrite("bounces", &RenderSettings::bounces)
      .def_readwrite("clamp_direct", &RenderSettings::clamp_direct)
      .def_readwrite("clamp_indirect", &RenderSettings::clamp_indirect)
      .def_readwrite("reflective_caustics", &RenderSettings::reflective_caustics)
      .def_readwrite("refractive_caustics", &RenderSettings::refractive_caustics)
      .def_readwrite("bump_terminator", &RenderSettings::bump_terminator)
      .def_readwrite("integrator", &RenderSettings::integrator)
      .def_readwrite("direct", &RenderSettings::direct)
      .def_readwrite("direct_samples", &RenderSettings::direct_samples)
      .def_readwrite("guiding", &RenderSettings::guiding)
      .def_readwrite("vertex_merging", &RenderSettings::vertex_merging)
      .def_readwrite("image", &RenderSettings::image)
      .def_readwrite("image_error", &RenderSettings::image_error)
      .def_readwrite("importance_region", &RenderSettings::importance_region)
      .def_readwrite("importance_factor", &RenderSettings::importance_factor)
      .def_readwrite("samples", &RenderSettings::samples)
      .def_readwrite("seconds", &RenderSettings::seconds)
      .def_readwrite("target_error", &RenderSettings::target_error)
      .def_readwrite("photons", &RenderSettings::photons)
      .def_readwrite("photon_radius", &RenderSettings::photon_radius)
      .def_readwrite("gather_rays", &RenderSettings::gather_rays)
      .def_readwrite("seed", &RenderSettings::seed)
      .def_readwrite("threads", &RenderSettings::threads)
      .def_readwrite("memory_limit", &RenderSettings::memory_limit)
      .def_property("mist", [](const RenderSettings& s) { return Vec3(s.mist.start, s.mist.depth, s.mist.exponent); },
                    [](RenderSettings& s, Vec3 mist) { s.mist = {mist.x, mist.y, mist.z}; })
      .def_readwrite("passes", &RenderSettings::passes);
}

}  // namespace

void bind_description(py::module_& module) {
  bind_enums(module);
  bind_geometry(module);
  bind_light_world_camera(module);
  bind_settings(module);

  py::class_<HintDescription>(module, "HintDescription")
      .def_readonly("name", &HintDescription::name)
      .def_property_readonly("points", [](const HintDescription& hint) { return to_array<float>(hint.points); })
      .def_readwrite("spread", &HintDescription::spread)
      .def_readonly("spreads", &HintDescription::spreads)
      .def_readwrite("weight", &HintDescription::weight)
      .def_readwrite("enabled", &HintDescription::enabled);
  py::class_<SceneDescription> scene(module, "SceneDescription", "A scene as plain data, in Blender's axes and units.");
  constexpr MeshArguments* mesh_arguments = nullptr;
  def_mesh(scene, "add_mesh", adder(mesh_arguments),
           "Add a mesh; arrays are copied once. `attributes` are tuples (name, Domain, values[n, components]).");
  def_mesh(module, "make_mesh", maker(mesh_arguments), "A mesh for any number of descriptions, see add_shared_mesh.");
  def_strands(module, "make_strands", &make_strands,
              "Hair, to be added by add_shared_mesh: float32[n, 3] and float32[n] of points, uint32[m] of the first point of each strand. "
              "Attributes are per point (Domain.Vertex) or per strand (Domain.Face), material slots per strand.");
  def_strands(scene, "add_strands", strands_adder(&make_strands), "Add the mesh that make_strands makes.");
  scene.def(py::init<>())
      .def("add_shared_mesh", &add_shared_mesh, py::arg("mesh"),
           "Add a mesh of make_mesh without a copy. Session.update keeps what it built of meshes that come again.")
      .def("add_object", &add_object, py::kw_only(), py::arg("name"), py::arg("mesh"), py::arg("materials") = std::vector<int>{},
           py::arg("visibility") = uint32_t(kVisibleAll), py::arg("holdout") = false, py::arg("shadow_catcher") = false,
           py::arg("pass_index") = 0, py::arg("color") = Vec4(1.0f), py::arg("importance") = 1.0f,
           py::arg("shadow_terminator_offset") = 0.0f, py::arg("light_importance") = 1.0f,
           py::arg("properties") = std::vector<std::tuple<std::string, bool, Vec4>>{},
           "`properties`, which Attribute nodes ask for: tuples (name, whether of the instancer, four numbers).")
      .def("add_instances", &add_instances, py::arg("objects"), py::arg("world_from_object"), py::arg("random") = py::none(),
           "Instances in bulk: int32[n], float32[n, 12] (three rows of four), float32[n].")
      .def("set_motion", &set_motion, py::arg("instances"), py::arg("world_from_object"),
           "Transforms at evenly spaced times while the shutter is open: int32[m] of instances, float32[m, keys, 12].")
      .def("add_image", &add_image, py::kw_only(), py::arg("name"), py::arg("path") = "", py::arg("packed") = py::bytes(),
           py::arg("pixels") = py::none(), py::arg("width") = 0, py::arg("height") = 0, py::arg("color_space") = "sRGB",
           py::arg("alpha_mode") = AlphaMode::Straight)
      .def(
          "add_material",
          [](SceneDescription& description, std::string name, const NodeGraph& graph, int pass_index) {
            description.materials.push_back({std::move(name), graph, pass_index});
            return index_of_last(description.materials.size());
          },
          py::kw_only(), py::arg("name"), py::arg("graph"), py::arg("pass_index") = 0)
      .def(
          "add_light",
          [](SceneDescription& description, const LightDescription& light) {
            description.lights.push_back(light);
            return index_of_last(description.lights.size());
          },
          py::arg("light"))
      .def(
          "add_hint",
          [](SceneDescription& description, std::string name, const Floats& points, float spread, std::vector<float> spreads, float weight, bool enabled) {
            HintDescription hint;
            hint.points = copy_rows<Vec3>(points, "points of " + name);
            hint.name = std::move(name);
            hint.spread = spread;
            hint.spreads = std::move(spreads);
            hint.weight = weight;
            hint.enabled = enabled;
            description.hints.push_back(std::move(hint));
            return index_of_last(description.hints.size());
          },
          py::kw_only(), py::arg("name"), py::arg("points"), py::arg("spread") = 0.0872665f, py::arg("spreads") = std::vector<float>(),
          py::arg("weight") = 1.0f, py::arg("enabled") = true,
          "A light path drawn by the artist: float32[n, 3] in world space, from a light to what the camera sees. `spread` is the half-angle of the cone "
          "around each of its n - 1 segments in radians, `spreads` that of single ones.")
      .def_property_readonly("meshes", &meshes_of)
      .def_readonly("objects", &SceneDescription::objects)
      .def_readonly("instances", &SceneDescription::instances)
      .def_readonly("materials", &SceneDescription::materials)
      .def_readonly("images", &SceneDescription::images)
      .def_readonly("hints", &SceneDescription::hints)
      .def_readonly("lights", &SceneDescription::lights)
      .def_readwrite("world", &SceneDescription::world)
      .def_readonly("motion_keys", &SceneDescription::motion_keys)
      .def_readwrite("camera", &SceneDescription::camera)
      .def_readwrite("settings", &SceneDescription::settings)
      .def("fingerprint", py::overload_cast<const SceneDescription&>(&fingerprint), py::call_guard<py::gil_scoped_release>(),
           "A number for everything but camera and settings: when it stays, nothing else has changed.");

  module.def("random_per_island", [](size_t vertex_count, const Array<uint32_t>& edges) {
        const auto pairs = copy_rows<MeshEdge>(edges, "edges");
        std::vector<float> random;
        {
          py::gil_scoped_release release;
          random = random_per_island(vertex_count, pairs);
        }
        return to_array<float>(random);
      }, py::arg("vertex_count"), py::arg("edges"), "float32[vertex_count]: a number that all connected vertices share. `edges`: uint32[n, 2].");
  module.def("pointiness", [](const Floats& positions, const Floats& normals, const Array<uint32_t>& edges) {
        const auto places = copy_rows<Vec3>(positions, "positions"), directions = copy_rows<Vec3>(normals, "normals");
        const auto pairs = copy_rows<MeshEdge>(edges, "edges");
        std::vector<float> found;
        {
          py::gil_scoped_release release;
          found = pointiness(places, directions, pairs);
        }
        return to_array<float>(found);
      }, py::arg("positions"), py::arg("normals"), py::arg("edges"),
      "How far each vertex stands out, 0.5 where flat: float32[n, 3] of vertices, uint32[m, 2] of edges.");
  module.def("save_description", &save_description, py::arg("description"), py::arg("path"), py::call_guard<py::gil_scoped_release>());
  module.def("load_description", &load_description, py::arg("path"), py::call_guard<py::gil_scoped_release>());
}

}  // namespace ajar::python
