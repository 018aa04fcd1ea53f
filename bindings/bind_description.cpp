// SceneDescription: geometry as NumPy arrays, other data field by field.
//
// The `add_*` functions return the index by which other parts refer to an item. Lists that are read from a description
// are copies.
#include "arrays.h"
#include "bind.h"
#include "description/archive.h"
#include "description/scene_description.h"
#include "geometry/mesh_analysis.h"
#include "geometry/uv_tangents.h"

namespace ajar::python {
namespace {

using OptionalFloats = std::optional<Floats>;
using Rows = std::array<float, 12>;

int index_of_last(size_t size) { return static_cast<int>(size) - 1; }

MeshDescription read_mesh(const std::string& name, const Floats& positions, const Array<uint32_t>& triangles,
                          const std::optional<Array<uint16_t>>& material_slots, const OptionalFloats& normals,
                          Domain normal_domain, const std::vector<py::tuple>& attributes, const std::string& active_uv,
                          Vec3 texture_space_location, Vec3 texture_space_size) {
  const std::string of = " of mesh \"" + name + "\"";
  MeshDescription mesh;
  mesh.name = name;
  mesh.positions = copy_rows<Vec3>(positions, "positions" + of);
  mesh.triangles = copy_rows<UVec3>(triangles, "triangles" + of);
  if (material_slots) mesh.material_slots = copy_rows<uint16_t>(*material_slots, "material_slots" + of);
  if (normals) mesh.normals = copy_rows<Vec3>(*normals, "normals" + of);
  mesh.normal_domain = normal_domain;
  for (const py::tuple& item : attributes) {
    if (item.size() != 3)
      throw py::value_error("attributes" + of + " must be tuples (name, domain, values[n, components])");
    const auto values = item[2].cast<Floats>();
    Attribute attribute;
    attribute.name = item[0].cast<std::string>();
    attribute.domain = item[1].cast<Domain>();
    attribute.components = values.ndim() == 2 ? int(values.shape(1)) : 1;
    if (attribute.components < 1 || attribute.components > 4)
      throw py::value_error("attribute \"" + attribute.name + "\"" + of + " must have 1 to 4 components, not " +
                            shape_text(values));
    attribute.values = copy_numbers(values);
    mesh.attributes.push_back(std::move(attribute));
  }
  mesh.active_uv = active_uv;
  mesh.texture_space_location = texture_space_location;
  mesh.texture_space_size = texture_space_size;
  return mesh;
}

std::shared_ptr<MeshDescription> make_strands(const std::string& name, const Floats& positions, const Floats& radii,
                                              const Array<uint32_t>& strands,
                                              const std::optional<Array<uint16_t>>& material_slots,
                                              const std::vector<py::tuple>& attributes, const std::string& active_uv,
                                              Vec3 texture_space_location, Vec3 texture_space_size, StrandShape shape,
                                              int subdivisions) {
  auto mesh = std::make_shared<MeshDescription>(read_mesh(name, positions, Array<uint32_t>(), material_slots,
                                                          std::nullopt, Domain::Vertex, attributes, active_uv,
                                                          texture_space_location, texture_space_size));
  mesh->radii = copy_rows<float>(radii, "radii of strands \"" + name + "\"");
  mesh->strands = copy_rows<uint32_t>(strands, "strands of \"" + name + "\"");
  mesh->strand_shape = shape;
  mesh->strand_subdivisions = subdivisions;
  return mesh;
}

/// Generated coordinates of a point cloud are positions in object space, as in Cycles.
std::shared_ptr<MeshDescription> make_points(const std::string& name, const Floats& positions, const Floats& radii,
                                             const std::optional<Array<uint16_t>>& material_slots,
                                             const std::vector<py::tuple>& attributes) {
  auto mesh = std::make_shared<MeshDescription>(read_mesh(name, positions, Array<uint32_t>(), material_slots,
                                                          std::nullopt, Domain::Vertex, attributes, "", Vec3(0.5f),
                                                          Vec3(0.5f)));
  mesh->radii = copy_rows<float>(radii, "radii of points \"" + name + "\"");
  return mesh;
}

/// A closed box around grids.
std::shared_ptr<MeshDescription> make_volume(const std::string& name, Vec3 lower, Vec3 upper,
                                             const std::vector<py::tuple>& grids, bool density_in_object_space,
                                             const std::optional<std::tuple<std::string, float, float>>& flow) {
  auto mesh = std::make_shared<MeshDescription>();
  mesh->name = name;
  for (int corner = 0; corner < 8; ++corner)
    mesh->positions.emplace_back(corner & 1 ? upper.x : lower.x, corner & 2 ? upper.y : lower.y,
                                 corner & 4 ? upper.z : lower.z);
  mesh->triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                     {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  mesh->texture_space_location = 0.5f * (lower + upper);
  mesh->texture_space_size = 0.5f * (upper - lower);
  mesh->density_in_object_space = density_in_object_space;
  if (flow) mesh->flow = {std::get<0>(*flow), std::get<1>(*flow), std::get<2>(*flow)};
  for (const py::tuple& item : grids) {
    if (item.size() != 4)
      throw py::value_error("grids of volume \"" + name +
                            "\" must be tuples (name, index_from_object, bricks, values)");
    VolumeGrid grid;
    grid.name = item[0].cast<std::string>();
    const std::string of = " of grid \"" + grid.name + "\" of volume \"" + name + "\"";
    grid.index_from_object = item[1].cast<Rows>();
    grid.bricks = copy_rows<std::array<int, 3>>(item[2].cast<Array<int32_t>>(), "bricks" + of);
    const auto values = item[3].cast<Floats>();
    const size_t voxels = grid.bricks.size() * VolumeGrid::kVoxels;
    const size_t components = voxels > 0 ? size_t(values.size()) / voxels : 1;
    grid.components = components == 3 || components == 4 ? int(components) : 1;
    if (size_t(values.size()) != size_t(grid.components) * voxels)
      throw py::value_error("values" + of + " must have 512, 3 * 512 or 4 * 512 numbers for each brick, not " +
                            shape_text(values));
    grid.values = copy_numbers(values);
    mesh->grids.push_back(std::move(grid));
  }
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

/// Defines `function`, whose last arguments are those of make_strands.
template <class Target, class Function>
void def_strands(Target& target, const char* name, Function function, const char* text) {
  target.def(name, function, py::kw_only(), py::arg("name"), py::arg("positions"), py::arg("radii"), py::arg("strands"),
             py::arg("material_slots") = py::none(), py::arg("attributes") = std::vector<py::tuple>{},
             py::arg("active_uv") = "", py::arg("texture_space_location") = Vec3(0.0f),
             py::arg("texture_space_size") = Vec3(1.0f), py::arg("shape") = StrandShape::Ribbon,
             py::arg("subdivisions") = 2, text);
}
template <class... Arguments>
auto mesh_adder(std::shared_ptr<MeshDescription> (*make)(Arguments...)) {
  return [make](SceneDescription& description, Arguments... arguments) {
    description.meshes.push_back(std::move(*make(arguments...)));
    return index_of_last(description.meshes.size());
  };
}

/// Defines `function`, whose last arguments are those of read_mesh.
template <class Target, class Function>
void def_mesh(Target& target, const char* name, Function function, const char* text) {
  target.def(name, function, py::kw_only(), py::arg("name"), py::arg("positions"), py::arg("triangles"),
             py::arg("material_slots") = py::none(), py::arg("normals") = py::none(),
             py::arg("normal_domain") = Domain::Corner, py::arg("attributes") = std::vector<py::tuple>{},
             py::arg("active_uv") = "", py::arg("texture_space_location") = Vec3(0.0f),
             py::arg("texture_space_size") = Vec3(1.0f), text);
}
using MeshArguments = MeshDescription(const std::string&, const Floats&, const Array<uint32_t>&,
                                      const std::optional<Array<uint16_t>>&, const OptionalFloats&, const Domain&,
                                      const std::vector<py::tuple>&, const std::string&, const Vec3&, const Vec3&);
template <class... Arguments>
auto adder(MeshDescription (*)(const Arguments&...)) {
  return &add_mesh<Arguments...>;
}
template <class... Arguments>
auto maker(MeshDescription (*)(const Arguments&...)) {
  return &make_mesh<Arguments...>;
}

/// The fields of ObjectProperty.
using Property = std::tuple<std::string, bool, Vec4, int>;

int add_object(SceneDescription& description, const std::string& name, int mesh, const std::vector<int>& materials,
               uint32_t visibility, bool holdout, bool shadow_catcher, int pass_index, Vec4 color, float importance,
               float shadow_terminator_offset, float light_importance, const std::vector<Property>& properties,
               int receiver_set, int blocker_set, uint64_t receivers, uint32_t blockers, const std::string& asset,
               const std::string& light_group) {
  if (receiver_set < 0 || receiver_set >= LightLinks::kReceiverSets)
    throw py::value_error("receiver_set of '" + name + "' must be 0 to RECEIVER_SETS - 1");
  if (blocker_set < 0 || blocker_set >= LightLinks::kBlockerSets)
    throw py::value_error("blocker_set of '" + name + "' must be 0 to BLOCKER_SETS - 1");
  description.objects.push_back({name,
                                 mesh,
                                 materials,
                                 visibility,
                                 holdout,
                                 shadow_catcher,
                                 pass_index,
                                 color,
                                 importance,
                                 shadow_terminator_offset,
                                 light_importance,
                                 {},
                                 uint8_t(receiver_set),
                                 uint8_t(blocker_set),
                                 {receivers, blockers},
                                 asset,
                                 light_group});
  for (const auto& [property, of_instancer, value, column] : properties)
    description.objects.back().properties.push_back({property, of_instancer, value, column});
  return index_of_last(description.objects.size());
}

void add_instances(SceneDescription& description, const Array<int32_t>& objects, const Floats& world_from_object,
                   const OptionalFloats& random) {
  const size_t count = check_rows(objects, 1, "objects");
  if (check_rows(world_from_object, 12, "world_from_object") != count)
    throw py::value_error("world_from_object must have one row of 12 per object");
  if (random && check_rows(*random, 1, "random") != count)
    throw py::value_error("random must have one number per object");
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

/// Sets what instances have from their instancers.
void set_origins(SceneDescription& description, const Array<int32_t>& instances, const Floats& values) {
  const size_t count = check_rows(instances, 1, "instances");
  if (check_rows(values, 18, "values") != count) throw py::value_error("values must have one row of 18 per instance");
  const float* row = values.data();
  const auto vector = [&](int at) { return Vec3(row[at], row[at + 1], row[at + 2]); };
  for (size_t i = 0; i < count; ++i, row += 18) {
    description.instances.at(size_t(instances.data()[i])).origin = int(description.instance_origins.size());
    description.instance_origins.push_back(
        {vector(0), {row[3], row[4]}, row[5], row[6], row[7], row[8], vector(9), vector(12), vector(15)});
  }
}

/// Sets the values that Attribute nodes read from the instancer for instances that have values of their own.
void set_instance_values(SceneDescription& description, const Array<int32_t>& instances, int columns,
                         const Floats& values) {
  const size_t count = check_rows(instances, 1, "instances");
  if (columns < 1) throw py::value_error("columns must be at least 1");
  if (check_rows(values, 4 * size_t(columns), "values") != count)
    throw py::value_error("values must have one row of 4 * columns numbers per instance");
  InstanceValues& all = description.instance_values;
  if (!all.values.empty() && all.columns != columns) throw py::value_error("columns must be the same in each call");
  const int first = int(all.values.size() / size_t(columns));
  for (size_t i = 0; i < count; ++i) description.instances.at(size_t(instances.data()[i])).values = first + int(i);
  all.columns = columns;
  for (const float* value = values.data(); value < values.data() + values.size(); value += 4)
    all.values.emplace_back(value[0], value[1], value[2], value[3]);
}

/// Sets the keys of instances that move while the shutter is open.
void set_motion(SceneDescription& description, const Array<int32_t>& instances, const Floats& world_from_object) {
  const size_t count = check_rows(instances, 1, "instances");
  const size_t keys = world_from_object.size() / 12;
  if (count == 0) return;
  if (world_from_object.size() % (12 * count) != 0)
    throw py::value_error("world_from_object must have the same number of rows of 12 for each instance");
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

/// Sets what each pixel sees: three corners with the directions to the eye, and the barycentric coordinates with their
/// changes along x and y.
void set_texels(CameraDescription& camera, const Array<bool>& shown, const Floats& corners, const Floats& eye,
                const Floats& barycentric) {
  const size_t count = check_rows(shown, 1, "shown");
  if (check_rows(corners, 9, "corners") != count || check_rows(eye, 9, "eye") != count ||
      check_rows(barycentric, 6, "barycentric") != count)
    throw py::value_error("shown, corners, eye and barycentric must have one row per texel");
  const auto three = [](const float* at) {
    return std::array{Vec3(at[0], at[1], at[2]), Vec3(at[3], at[4], at[5]), Vec3(at[6], at[7], at[8])};
  };
  camera.texels.resize(count);
  for (size_t i = 0; i < count; ++i) {
    const float* b = barycentric.data() + 6 * i;
    camera.texels[i] = {
        shown.data()[i], three(corners.data() + 9 * i), three(eye.data() + 9 * i), {b[0], b[1]}, {b[2], b[3]},
        {b[4], b[5]}};
  }
}

/// Sets the transforms of instances one frame before and one after.
void set_frames(SceneDescription& description, const Array<int32_t>& instances, const Floats& world_from_object) {
  const size_t count = check_rows(instances, 1, "instances");
  if (size_t(world_from_object.size()) != 2 * 12 * count)
    throw py::value_error("world_from_object must have two rows of 12 for each instance");
  for (size_t i = 0; i < count; ++i) {
    description.instances.at(size_t(instances.data()[i])).first_frame_key = int(description.motion_keys.size());
    for (size_t k = 0; k < 2; ++k) {
      Rows rows;
      std::memcpy(rows.data(), world_from_object.data() + 12 * (2 * i + k), sizeof(Rows));
      description.motion_keys.push_back(rows);
    }
  }
}

/// Adds an attribute of three components to the vertices of a mesh.
void set_vertex_attribute(SceneDescription& description, int mesh, const std::string& name, const Floats& values) {
  MeshDescription& changed = description.meshes.at(size_t(mesh));
  if (changed.shared) changed = MeshDescription(*changed.shared);
  if (check_rows(values, 3, "values") != changed.positions.size())
    throw py::value_error("values must have one row of 3 for each of the " + std::to_string(changed.positions.size()) +
                          " vertices");
  changed.attributes.push_back({name, Domain::Vertex, 3, copy_numbers(values)});
}

/// Sets the shapes of a mesh while the shutter is open.
void set_shapes(SceneDescription& description, int mesh, const Floats& positions, const OptionalFloats& normals,
                const OptionalFloats& radii) {
  MeshDescription& changed = description.meshes.at(size_t(mesh));
  if (changed.shared) changed = MeshDescription(*changed.shared);
  const size_t each = 3 * changed.positions.size();
  const size_t shapes = each > 0 ? size_t(positions.size()) / each : 0;
  if (shapes < 2 || size_t(positions.size()) != shapes * each)
    throw py::value_error("positions must have a row of 3 for each vertex at each of at least two times");
  if (normals && size_t(normals->size()) != 3 * shapes * changed.normals.size())
    throw py::value_error("normals must have a row of 3 for each normal of the mesh at each time");
  if (radii && size_t(radii->size()) != shapes * changed.radii.size())
    throw py::value_error("radii must have a number for each radius of the mesh at each time");
  const auto copy = [](std::vector<Vec3>& to, const Floats& from) {
    to.resize(size_t(from.size()) / 3);
    std::memcpy(to.data(), from.data(), to.size() * sizeof(Vec3));
  };
  copy(changed.motion_positions, positions);
  if (normals) copy(changed.motion_normals, *normals);
  if (radii) changed.motion_radii = copy_numbers(*radii);
}

void set_color_spaces(SceneDescription& description, std::string config, std::string working_space) {
  description.color = {std::move(config), std::move(working_space)};
}

int add_image(SceneDescription& description, const std::string& name, const std::string& path, const py::bytes& packed,
              const OptionalFloats& pixels, int width, int height, const std::string& color_space, AlphaMode alpha_mode,
              int size_limit, float resolution) {
  ImageDescription image;
  image.name = name;
  image.path = path;
  const std::string_view bytes = packed;
  image.packed.assign(bytes.begin(), bytes.end());
  if (pixels) {
    if (size_t(pixels->size()) != size_t(width) * height * 4)
      throw py::value_error("pixels of image \"" + name + "\" must be width * height * 4 floats, not " +
                            shape_text(*pixels));
    image.pixels = copy_numbers(*pixels);
  }
  image.width = width;
  image.height = height;
  image.color_space = color_space;
  image.alpha_mode = alpha_mode;
  image.size_limit = size_limit;
  image.resolution = resolution;
  description.images.push_back(std::move(image));
  return index_of_last(description.images.size());
}

int add_tiled_image(SceneDescription& description, const std::string& name,
                    const std::vector<std::pair<int, int>>& tiles) {
  ImageDescription image;
  image.name = name;
  for (const auto& [number, index] : tiles) image.tiles.push_back({number, index});
  description.images.push_back(std::move(image));
  return index_of_last(description.images.size());
}

void bind_enums(py::module_& module) {
  py::enum_<AlphaMode>(module, "AlphaMode", "How the colours and the alpha of an image are related.")
      .value("Straight", AlphaMode::Straight, "Colours are not multiplied by alpha.")
      .value("Premultiplied", AlphaMode::Premultiplied, "Colours are multiplied by alpha.")
      .value("ChannelPacked", AlphaMode::ChannelPacked, "Alpha is a separate channel; colours are read unchanged.")
      .value("None_", AlphaMode::None, "Alpha is ignored and read as 1.")
      .value("AlwaysStraight", AlphaMode::AlwaysStraight, "Straight, whatever the file says.")
      .value("AlwaysPremultiplied", AlphaMode::AlwaysPremultiplied, "Premultiplied, whatever the file says.");
  py::enum_<Domain>(module, "Domain", "The elements of a mesh that values belong to.")
      .value("Vertex", Domain::Vertex, "A vertex, or a point of a strand or of a point cloud.")
      .value("Corner", Domain::Corner, "A corner of a triangle.")
      .value("Face", Domain::Face, "A triangle, or a strand.");
  py::enum_<StrandShape>(module, "StrandShape", "The shape of hair.")
      .value("Ribbon", StrandShape::Ribbon, "Flat, faces each ray, shaded as a tube.")
      .value("Round", StrandShape::Round, "A tube.")
      .value("Linear", StrandShape::Linear,
             "A tube of straight pieces between the points, with round joints and ends.");
  py::enum_<LightKind>(module, "LightKind", "The kind of a lamp.")
      .value("Point", LightKind::Point, "A sphere, or a point.")
      .value("Spot", LightKind::Spot, "A point lamp with a cone.")
      .value("Sun", LightKind::Sun, "A lamp at infinity.")
      .value("Area", LightKind::Area, "A rectangle or an ellipse.");
  py::enum_<AreaShape>(module, "AreaShape", "The shape of an area lamp.")
      .value("Rectangle", AreaShape::Rectangle, "A rectangle.")
      .value("Ellipse", AreaShape::Ellipse, "An ellipse.");
  py::enum_<CameraKind>(module, "CameraKind", "The kind of a camera.")
      .value("Perspective", CameraKind::Perspective, "Central projection.")
      .value("Orthographic", CameraKind::Orthographic, "Parallel projection.")
      .value("Panorama", CameraKind::Panorama, "One of PanoramaKind.")
      .value("Texels", CameraKind::Texels, "Each pixel sees its own place on a surface, for baking.");
  py::enum_<PanoramaKind>(module, "PanoramaKind", "The projection of a panoramic camera.")
      .value("Equirectangular", PanoramaKind::Equirectangular, "Longitude and latitude.")
      .value("FisheyeEquidistant", PanoramaKind::FisheyeEquidistant, "The radius is proportional to the angle.")
      .value("FisheyeEquisolid", PanoramaKind::FisheyeEquisolid, "Equal areas are equal solid angles.")
      .value("FisheyePolynomial", PanoramaKind::FisheyePolynomial, "The angle is a polynomial of the radius.")
      .value("MirrorBall", PanoramaKind::MirrorBall, "The image of a mirror ball.")
      .value("CubemapFace", PanoramaKind::CubemapFace, "One face of a cube map.");
  py::enum_<FilterKind>(module, "FilterKind", "The pixel filter.")
      .value("Box", FilterKind::Box, "Constant over the pixel.")
      .value("Gaussian", FilterKind::Gaussian, "A truncated Gaussian.")
      .value("BlackmanHarris", FilterKind::BlackmanHarris, "Blender's default.");
  py::enum_<BumpTerminator>(module, "BumpTerminator", "How light fades at grazing angles on bumped surfaces.")
      .value("Cubic", BumpTerminator::Cubic, "A cubic of the cosines, as in Blender until 4.4.")
      .value("Microfacet", BumpTerminator::Microfacet, "Shadowing by GGX, as in Blender since 4.5.")
      .value("None_", BumpTerminator::None, "It does not fade.");
  module.attr("UNDEFORMED_POSITION") = kUndeformedPosition;
  module.attr("RANDOM_PER_ISLAND") = kRandomPerIsland;
  module.attr("POSITION_BEFORE") = kPositionBefore;
  module.attr("POSITION_AFTER") = kPositionAfter;
  module.attr("FLAT_FACES") = kFlatFaces;
  module.attr("POINTINESS") = kPointiness;
  module.attr("TANGENT_OF") = kTangentOf;
  module.attr("VISIBLE_CAMERA") = int(kVisibleCamera);
  module.attr("VISIBLE_DIFFUSE") = int(kVisibleDiffuse);
  module.attr("VISIBLE_GLOSSY") = int(kVisibleGlossy);
  module.attr("VISIBLE_TRANSMISSION") = int(kVisibleTransmission);
  module.attr("VISIBLE_VOLUME_SCATTER") = int(kVisibleVolumeScatter);
  module.attr("VISIBLE_SHADOW") = int(kVisibleShadow);
  module.attr("RECEIVER_SETS") = LightLinks::kReceiverSets;
  module.attr("BLOCKER_SETS") = LightLinks::kBlockerSets;
  module.attr("VISIBLE_ALL") = int(kVisibleAll);
}

void bind_geometry(py::module_& module) {
  py::class_<Attribute>(module, "Attribute", "A named attribute of a mesh.")
      .def_readonly("name", &Attribute::name, "str. The name by which nodes read it.")
      .def_readonly("domain", &Attribute::domain, "Domain. The elements that the values belong to.")
      .def_readonly("components", &Attribute::components, "int, 1 to 4. The number of floats for each element.")
      .def_property_readonly(
          "values", [](const Attribute& a) { return to_array<float>(a.values, a.components); },
          "float32[n, components], or float32[n] for one component; n is the number of elements of the domain. A "
          "copy.");
  py::class_<MeshDescription, std::shared_ptr<MeshDescription>>(
      module, "MeshDescription",
      "A mesh of triangles in object space, strands of hair, or a point cloud. Its arrays are copies.")
      .def_readonly("name", &MeshDescription::name, "str. The name of the mesh in Blender, used in messages.")
      .def_property_readonly(
          "positions", [](const MeshDescription& m) { return to_array<float>(m.positions); },
          "float32[n, 3], metres. The vertices in object space; for hair the points of all strands.")
      .def_property_readonly(
          "motion_positions", [](const MeshDescription& m) { return to_array<float>(m.motion_positions); },
          "float32[k * n, 3], metres. The positions at k evenly spaced times while the shutter is open, one time after "
          "another. An empty array means that the shape does not change.")
      .def_property_readonly(
          "triangles", [](const MeshDescription& m) { return to_array<uint32_t>(m.triangles); },
          "uint32[t, 3], 0 to n - 1. The vertices of each triangle. Corner 3 t + k is vertex k of triangle t. Empty "
          "for hair.")
      .def_property_readonly(
          "material_slots", [](const MeshDescription& m) { return to_array<uint16_t>(m.material_slots); },
          "uint16[t]. The material slot of each triangle or strand. An empty array means slot 0 everywhere.")
      .def_property_readonly(
          "normals", [](const MeshDescription& m) { return to_array<float>(m.normals); },
          "float32[m, 3], unit vectors in object space. Shading normals, one for each element of `normal_domain`. An "
          "empty array means flat shading.")
      .def_readonly("normal_domain", &MeshDescription::normal_domain,
                    "Domain, Vertex or Corner. The elements that `normals` belong to.")
      .def_readonly("attributes", &MeshDescription::attributes,
                    "list of Attribute. The named attributes: UV maps, colours and the like.")
      .def_readonly("active_uv", &MeshDescription::active_uv,
                    "str. The name of the UV map that is used if a node names none.")
      .def_property_readonly(
          "strands", [](const MeshDescription& m) { return to_array<uint32_t>(m.strands); },
          "uint32[s], ascending, the first 0. The index of the first point of each strand. Empty for a mesh of "
          "triangles.")
      .def_property_readonly(
          "radii", [](const MeshDescription& m) { return to_array<float>(m.radii); },
          "float32[n], metres, >= 0. The radius of a strand at each of its points, or of each point of a point cloud. "
          "Empty for a mesh of triangles.")
      .def_readonly("strand_shape", &MeshDescription::strand_shape,
                    "StrandShape. The shape of all strands of the mesh.")
      .def_readonly("strand_subdivisions", &MeshDescription::strand_subdivisions,
                    "int, 0 to 4. Each segment of a ribbon has 2^strand_subdivisions straight pieces.")
      .def_property_readonly(
          "grids",
          [](const MeshDescription& m) {
            std::vector<py::tuple> grids;
            for (const VolumeGrid& grid : m.grids)
              grids.push_back(py::make_tuple(grid.name, grid.index_from_object, to_array<int>(grid.bricks),
                                             to_array<float>(grid.values, VolumeGrid::kVoxels * grid.components)));
            return grids;
          },
          "list of tuples (name, index_from_object, bricks, values), as in make_volume, but with one row of values for "
          "each brick. The grids of a volume.")
      .def_property_readonly("subdivision", &subdivision_of,
                             "dict of the arguments of `set_subdivision`, or None. The faces of a mesh with adaptive "
                             "subdivision.")
      .def_readonly("density_in_object_space", &MeshDescription::density_in_object_space,
                    "bool. The volume keeps its optical depth when an instance is scaled.")
      .def_property_readonly(
          "flow",
          [](const MeshDescription& mesh) {
            return std::make_tuple(mesh.flow.velocity, mesh.flow.scale, mesh.flow.frame);
          },
          "tuple (str, float, float). The `flow` of make_volume; the name is empty if nothing flows.")
      .def_readonly("texture_space_location", &MeshDescription::texture_space_location,
                    "tuple of 3 floats, metres in object space. The centre of the box of Generated coordinates.")
      .def_readonly("texture_space_size", &MeshDescription::texture_space_size,
                    "tuple of 3 floats, metres. Half the extent of the box of Generated coordinates.");
  py::class_<ObjectDescription>(module, "ObjectDescription",
                                "The data that instances share: a mesh and the materials of its slots.")
      .def_readonly("name", &ObjectDescription::name, "str. The name in Blender, used in messages.")
      .def_readonly("mesh", &ObjectDescription::mesh,
                    "int. The index of the mesh. -1 means no mesh, so that instances of the object are skipped.")
      .def_readonly("materials", &ObjectDescription::materials,
                    "list of int. The index of the material of each slot. -1 is the default grey material.")
      .def_readonly("visibility", &ObjectDescription::visibility,
                    "int, a sum of VISIBLE_* bits, 0 to VISIBLE_ALL. The kinds of ray that see the object.")
      .def_readonly("holdout", &ObjectDescription::holdout,
                    "bool. Whether the object cuts a hole into the alpha of the image.")
      .def_readonly("shadow_catcher", &ObjectDescription::shadow_catcher,
                    "bool. Whether the object is invisible and shows the shadows on it (path tracing).")
      .def_readonly("receiver_set", &ObjectDescription::receiver_set,
                    "int, 0 to RECEIVER_SETS - 1. The set of the object for light linking.")
      .def_readonly("blocker_set", &ObjectDescription::blocker_set,
                    "int, 0 to BLOCKER_SETS - 1. The set of the object for shadow linking.")
      .def_property_readonly(
          "receivers", [](const ObjectDescription& object) { return object.links.receivers; },
          "int, 64 bits. Bit s: the emission of the object lights objects of receiver set s.")
      .def_property_readonly(
          "blockers", [](const ObjectDescription& object) { return object.links.blockers; },
          "int, 32 bits. Bit s: objects of blocker set s block the light that the object emits.")
      .def_readonly("pass_index", &ObjectDescription::pass_index,
                    "int. The value of the pass IndexOB and of Object Info > Object Index.")
      .def_readonly("color", &ObjectDescription::color,
                    "tuple of 4 floats, linear RGBA. The value of Object Info > Color.")
      .def_readonly("importance", &ObjectDescription::importance,
                    "float, >= 0, 1 is neutral. A factor for the number of samples of pixels that show the object. It "
                    "is used with `RenderSettings.image` \"pmc_ip\" and never changes the mean of the image. Negative "
                    "and non-finite values are read as 1.")
      .def_readonly("shadow_terminator_offset", &ObjectDescription::shadow_terminator_offset,
                    "float, 0 to 1. The cosine to the light below which shadow rays from smooth triangles start at the "
                    "curved surface that the triangles approximate. 0 switches this off.")
      .def_readonly("asset", &ObjectDescription::asset,
                    "str. The name of its topmost parent, for the pass Cryptomatte Asset; empty for itself.")
      .def_readonly("light_group", &ObjectDescription::light_group,
                    "str. The light group of its emission; empty for none.")
      .def_readonly("light_importance", &ObjectDescription::light_importance,
                    "float, >= 0, 1 is neutral. A factor for the number of samples of pixels that are lit by emission "
                    "of the object. It is used with `RenderSettings.image` \"pmc_ip\" and never changes the mean of "
                    "the image. Negative and non-finite values are read as 1.")
      .def_property_readonly(
          "properties",
          [](const ObjectDescription& o) {
            std::vector<Property> found;
            for (const ObjectProperty& property : o.properties)
              found.emplace_back(property.name, property.of_instancer, property.value, property.column);
            return found;
          },
          "list of (str, bool, tuple of 4 floats, int). The values for Attribute nodes: name, whether the value "
          "belongs "
          "to the instancer, value, and the column of set_instance_values, or -1.");
  py::class_<InstanceDescription>(module, "InstanceDescription", "An object placed in the world.")
      .def_readonly("object", &InstanceDescription::object, "int. The index of the object.")
      .def_readonly("world_from_object", &InstanceDescription::world_from_object,
                    "list of 12 floats, three rows of four. The affine transform from object space to world space, "
                    "lengths in metres.")
      .def_readonly("motion_key_count", &InstanceDescription::motion_key_count,
                    "int, 0 or 2 to 129. The number of transforms while the shutter is open. 0 means that the instance "
                    "does not move.")
      .def_readonly("first_frame_key", &InstanceDescription::first_frame_key,
                    "int. The index of the transforms one frame before and one after in `motion_keys`; -1 if they are "
                    "the same as now.")
      .def_readonly("random", &InstanceDescription::random, "float, 0 to 1. The value of Object Info > Random.");
  py::class_<ImageDescription>(module, "ImageDescription",
                               "An image for textures. Its source is a path, a packed file or pixels. An image that "
                               "cannot be read renders magenta and is reported by name.")
      .def_readonly("name", &ImageDescription::name, "str. The name in Blender, used in messages.")
      .def_readonly("path", &ImageDescription::path,
                    "str. The path of the image file. Empty when the image has another source.")
      .def_property_readonly(
          "packed_size", [](const ImageDescription& i) { return i.packed.size(); },
          "int, bytes. The size of the packed image file. 0 when the image has another source.")
      .def_property_readonly(
          "pixels", [](const ImageDescription& i) { return to_array<float>(i.pixels, 4); },
          "float32[width * height, 4], RGBA, rows from the bottom up. Empty when the image has another source. A copy.")
      .def_readonly("width", &ImageDescription::width,
                    "int, pixels, >= 0. The width of `pixels`; 0 when there are none.")
      .def_readonly("height", &ImageDescription::height,
                    "int, pixels, >= 0. The height of `pixels`; 0 when there are none.")
      .def_readonly("color_space", &ImageDescription::color_space,
                    "str. The name of the colour space in the OpenColorIO configuration, such as \"sRGB\". "
                    "\"Non-Color\" are no colours, \"scene_linear\" is the working space.")
      .def_property_readonly(
          "tiles",
          [](const ImageDescription& i) {
            std::vector<std::pair<int, int>> tiles;
            for (const ImageTile& tile : i.tiles) tiles.emplace_back(tile.number, tile.image);
            return tiles;
          },
          "Tuples (number, index of the image) of a tiled image. Empty when the image has another source.")
      .def_readonly("alpha_mode", &ImageDescription::alpha_mode,
                    "AlphaMode. How the colours and the alpha of the image are related.")
      .def_readonly("size_limit", &ImageDescription::size_limit,
                    "int, texels, >= 0. The maximum of the longer side of the texture; 0 for no limit.")
      .def_readonly("resolution", &ImageDescription::resolution,
                    "float, 0 to 1. The maximum fraction of the sides of the image that the texture has.");
}

void bind_light_world_camera(py::module_& module) {
  py::class_<LightDescription>(module, "LightDescription", "A lamp of Blender.")
      .def(py::init<>(), "Make one with default values.")
      .def_readwrite("name", &LightDescription::name, "str. The name in Blender, used in messages.")
      .def_readwrite("kind", &LightDescription::kind, "LightKind. The kind of lamp. It emits along its local -z axis.")
      .def_readwrite("world_from_light", &LightDescription::world_from_light,
                     "list of 12 floats, three rows of four. The affine transform from lamp space to world space, "
                     "lengths in metres.")
      .def_readwrite("color", &LightDescription::color,
                     "tuple of 3 floats, linear RGB, no unit. A factor on `energy`. Negative values remove light.")
      .def_readwrite("energy", &LightDescription::energy,
                     "float, W for point, spot and area lamps, W/m^2 for a sun. The power as in Cycles. Negative "
                     "values remove light.")
      .def_readwrite("radius", &LightDescription::radius,
                     "float, metres, >= 0. The radius of the sphere of a point or spot lamp. 0 is a delta light.")
      .def_readwrite(
          "soft_falloff", &LightDescription::soft_falloff,
          "bool. Whether a point or spot lamp is a disk of this radius that faces each lit point, instead of "
          "a sphere. It illuminates what is close to it less, and what is inside it as well.")
      .def_readwrite(
          "even_spot", &LightDescription::even_spot,
          "bool. Whether the light of a spot lamp is as strong everywhere in its cone, which has the scale of "
          "the lamp, as since Blender 4.0. Otherwise it falls with the cosine to the axis.")
      .def_readwrite(
          "own_coordinates", &LightDescription::own_coordinates,
          "bool. Whether Object and Generated coordinates in its nodes are in the space of the lamp, not of the world.")
      .def_readwrite("has_uv", &LightDescription::has_uv,
                     "bool. Whether its nodes have UV coordinates; otherwise they are 0.")
      .def_readwrite("even_sun", &LightDescription::even_sun,
                     "bool. Whether a sun has the same radiance in its whole cone, and its energy is the irradiance of "
                     "a surface that faces it, as since Blender 4.0. Otherwise its radiance grows with 1 / cos^3 from "
                     "the axis, and the irradiance of a large sun is less.")
      .def_readwrite("spot_angle", &LightDescription::spot_angle,
                     "float, radians, 0 to pi. The full angle of the cone of a spot lamp.")
      .def_readwrite("spot_blend", &LightDescription::spot_blend,
                     "float, 0 to 1. The part of the spot's cone in which the light fades to 0.")
      .def_readwrite("sun_angle", &LightDescription::sun_angle,
                     "float, radians, 0 to pi. The full angle of the disk of a sun. 0 is a delta light.")
      .def_readwrite("area_shape", &LightDescription::area_shape, "AreaShape. The shape of an area lamp.")
      .def_readwrite("area_size", &LightDescription::area_size,
                     "tuple of 2 floats, metres, > 0. The full extents of an area lamp along its local x and y axes.")
      .def_readwrite("spread", &LightDescription::spread,
                     "float, radians, pi / 180 to pi. The full angle of the beam of an area lamp. pi is no limit.")
      .def_readwrite("graph", &LightDescription::graph,
                     "NodeGraph. The shader of the lamp. Its Emission is a factor on the lamp's own light. An empty "
                     "graph means a factor of 1.")
      .def_readwrite("visibility", &LightDescription::visibility,
                     "int, a sum of VISIBLE_* bits, 0 to VISIBLE_ALL. The kinds of ray that see the lamp.")
      .def_readwrite("cast_shadow", &LightDescription::cast_shadow,
                     "bool. Whether objects block the light of the lamp.")
      .def_readwrite("multiple_importance", &LightDescription::multiple_importance,
                     "bool. Whether rays can hit the lamp, so that light samples and BSDF samples are combined. It has "
                     "no effect on delta lights.")
      .def_readwrite("light_group", &LightDescription::light_group, "str. The light group; empty for none.")
      .def_readwrite("light_importance", &LightDescription::light_importance,
                     "float, >= 0, 1 is neutral. A factor for the number of samples of pixels that are lit by the "
                     "lamp. It is used with `RenderSettings.image` \"pmc_ip\" and never changes the mean of the image. "
                     "Negative and non-finite values are read as 1.")
      .def_property(
          "receivers", [](const LightDescription& light) { return light.links.receivers; },
          [](LightDescription& light, uint64_t sets) { light.links.receivers = sets; },
          "int, 64 bits. Bit s: the lamp lights objects of receiver set s (SceneDescription.add_object).")
      .def_property(
          "blockers", [](const LightDescription& light) { return light.links.blockers; },
          [](LightDescription& light, uint32_t sets) { light.links.blockers = sets; },
          "int, 32 bits. Bit s: objects of blocker set s block the light of the lamp.")
      .def_readwrite("max_bounces", &LightDescription::max_bounces,
                     "int, >= 0. After more bounces, path tracing does not sample the lamp any more.");
  py::class_<WorldDescription>(module, "WorldDescription", "The environment of the scene.")
      .def_readwrite("name", &WorldDescription::name, "str. The name in Blender, used in messages.")
      .def_readwrite("graph", &WorldDescription::graph,
                     "NodeGraph. The shader of the world. An empty graph means the constant `color`.")
      .def_readwrite(
          "color", &WorldDescription::color,
          "tuple of 3 floats, linear RGB radiance in W/(m^2 sr). The constant background if `graph` is empty.")
      .def_readwrite("visibility", &WorldDescription::visibility,
                     "int, a sum of VISIBLE_* bits, 0 to VISIBLE_ALL. The kinds of ray that see the world.")
      .def_readwrite("max_bounces", &WorldDescription::max_bounces,
                     "int, >= 0. After more bounces, path tracing does not sample the world any more.")
      .def_readwrite("light_group", &WorldDescription::light_group, "str. The light group; empty for none.")
      .def_readwrite("light_importance", &WorldDescription::light_importance,
                     "float, >= 0, 1 is neutral. A factor for the number of samples of pixels that are lit by the "
                     "world. It is used with `RenderSettings.image` \"pmc_ip\" and never changes the mean of the "
                     "image. Negative and non-finite values are read as 1.");
  py::class_<PanoramaDescription>(
      module, "PanoramaDescription",
      "The projection of a panoramic camera. Two descriptions are equal when all fields are equal.")
      .def(py::init<>(), "Make one with default values.")
      .def("__eq__", [](const PanoramaDescription& a, const PanoramaDescription& b) { return a == b; })
      .def_readwrite("kind", &PanoramaDescription::kind, "PanoramaKind. The projection.")
      .def_readwrite("limits", &PanoramaDescription::limits,
                     "tuple of 4 floats, radians. Equirectangular only: minimum longitude, maximum longitude, minimum "
                     "latitude, maximum latitude.")
      .def_readwrite("fisheye_fov", &PanoramaDescription::fisheye_fov,
                     "float, radians, > 0. Fisheye only: the full angle of view.")
      .def_readwrite("fisheye_lens", &PanoramaDescription::fisheye_lens,
                     "float, millimetres, > 0. FisheyeEquisolid only: the focal length.")
      .def_readwrite(
          "sensor", &PanoramaDescription::sensor,
          "tuple of 2 floats, millimetres, > 0. FisheyeEquisolid and FisheyePolynomial only: the size of the sensor.")
      .def_readwrite("polynomial", &PanoramaDescription::polynomial,
                     "list of 5 floats. FisheyePolynomial only: the coefficients k_i of the angle from the axis in "
                     "radians, -(k_0 + k_1 r + ... + k_4 r^4), r in millimetres from the centre of the sensor.");
  py::class_<CameraDescription>(module, "CameraDescription",
                                "The camera. Two descriptions are equal when all fields are equal.")
      .def(py::init<>(), "Make one with default values.")
      .def("__eq__", [](const CameraDescription& a, const CameraDescription& b) { return a == b; })
      .def_readwrite("name", &CameraDescription::name, "str. The name in Blender, used in messages.")
      .def_readwrite("present", &CameraDescription::present,
                     "bool. Whether the scene has a camera. A render without one fails with a message.")
      .def_readwrite("kind", &CameraDescription::kind, "CameraKind. The projection.")
      .def_readwrite("world_from_camera", &CameraDescription::world_from_camera,
                     "list of 12 floats, three rows of four. The affine transform from camera space to world space, "
                     "lengths in metres. The camera looks along its local -z axis, +y is up.")
      .def_readwrite(
          "screen_window", &CameraDescription::screen_window,
          "tuple of 4 floats: left, right, bottom, top. The visible part of the plane z = -1 for a perspective camera, "
          "metres for an orthographic one, fractions of the whole panorama (0, 1, 0, 1) for a panoramic one.")
      .def_readwrite("clip_start", &CameraDescription::clip_start,
                     "float, metres. Surfaces that are nearer are not seen by camera rays.")
      .def_readwrite("clip_end", &CameraDescription::clip_end,
                     "float, metres, > clip_start. Surfaces that are farther are not seen by camera rays.")
      .def_readwrite("aperture_radius", &CameraDescription::aperture_radius,
                     "float, metres, >= 0. The radius of the lens. 0 switches depth of field off.")
      .def_readwrite("focus_distance", &CameraDescription::focus_distance,
                     "float, metres, > 0. The distance of the plane that is in focus.")
      .def_readwrite("blades", &CameraDescription::blades,
                     "int. The number of blades of the aperture. Less than 3 means a round aperture.")
      .def_readwrite("blade_rotation", &CameraDescription::blade_rotation,
                     "float, radians. The rotation of the aperture.")
      .def_readwrite("aperture_ratio", &CameraDescription::aperture_ratio,
                     "float, > 0. The height of the aperture over its width: 2 is an anamorphic lens.")
      .def_readwrite("panorama", &CameraDescription::panorama, "PanoramaDescription. Used when `kind` is Panorama.")
      .def_property(
          "stereo",
          [](const CameraDescription& camera) {
            const StereoDescription& eye = camera.stereo;
            return std::array<float, 4>{eye.offset, eye.convergence, eye.merge_from, eye.merge_to};
          },
          [](CameraDescription& camera, const std::array<float, 4>& v) {
            camera.stereo = {v[0], v[1], v[2], v[3]};
          },
          "list of 4 floats. Spherical stereoscopy: the offset of the eye to the right of the centre in metres (0: no "
          "stereoscopy), the distance at which the rays of both eyes meet (0: they are parallel), and the angles from "
          "the horizon in radians between which both eyes move to the centre (0 and 0: they stay).")
      .def_readwrite("motion", &CameraDescription::motion,
                     "list of lists of 12 floats. `world_from_camera` at evenly spaced times while the shutter is "
                     "open. An empty list means that the camera does not move.")
      .def("set_texels", &set_texels, py::arg("shown"), py::arg("corners"), py::arg("eye"), py::arg("barycentric"),
           "Set what each pixel sees when `kind` is Texels; rows from the bottom up.\n\n"
           "shown: bool array [n]; the other pixels see nothing. corners: float array [n, 9], metres in world space, "
           "three "
           "corners of a triangle. eye: float array [n, 9], unit directions to the eye at the corners. barycentric: "
           "float array [n, 6], the coordinates of the first two corners, how they change to the next pixel along x, "
           "and along y. Raises ValueError if the numbers of rows differ.")
      .def_readwrite("frames", &CameraDescription::frames,
                     "list of two lists of 12 floats. `world_from_camera` one frame before and one after, for the pass "
                     "Vector. An empty list means that the camera does not move.")
      .def_readwrite("window_motion", &CameraDescription::window_motion,
                     "list of tuples of 4 floats. `screen_window` at evenly spaced times while the shutter is open. An "
                     "empty list means that it does not change.")
      .def_readwrite(
          "row_exposure", &CameraDescription::row_exposure,
          "float, 0 to 1. Rolling shutter: the part of the shutter interval while which one row of pixels is "
          "exposed, from the top row to the bottom row. 1 exposes all rows together. Path Tracing renders "
          "the scene if it is less.")
      .def_readwrite("shutter", &CameraDescription::shutter,
                     "list of floats, ascending from 0 to 1. The times at which equal shares of the light have "
                     "arrived. An empty list means that the shutter opens and closes instantly.");
}

}  // namespace

void bind_description(py::module_& module) {
  bind_enums(module);
  bind_geometry(module);
  bind_light_world_camera(module);
  bind_subdivision(module);
  bind_settings(module);

  py::class_<HintDescription>(module, "HintDescription",
                              "A light hint: a curve from a light, over surfaces, towards what the camera sees. Hints "
                              "only propose paths and never change the mean of the image.")
      .def_readonly("name", &HintDescription::name, "str. The name in Blender, used in messages.")
      .def_property_readonly(
          "points", [](const HintDescription& hint) { return to_array<float>(hint.points); },
          "float32[n, 3], metres in world space. The control points, the first near a light. A copy.")
      .def_readwrite("spread", &HintDescription::spread,
                     "float, radians, > 0 to pi. The half-angle of the cone around each segment.")
      .def_readonly(
          "spreads", &HintDescription::spreads,
          "list of floats, radians. The half-angles of the first segments. Segments without an entry use `spread`.")
      .def_readwrite("weight", &HintDescription::weight,
                     "float, >= 0. The relative probability that this hint is chosen. A hint of weight 0 is not used.")
      .def_readwrite("enabled", &HintDescription::enabled, "bool. Whether the hint is used.");
  py::class_<SceneDescription> scene(
      module, "SceneDescription",
      "A scene as plain data, in Blender's axes (z up) and units (metres). The `add_*` methods return the index that "
      "other parts refer to. Lists that are read from a description are copies.");
  constexpr MeshArguments* mesh_arguments = nullptr;
  def_mesh(scene, "add_mesh", adder(mesh_arguments),
           "Add a mesh and return its index. Arrays are copied once. positions: float32[n, 3] in metres, object space. "
           "triangles: uint32[t, 3] of vertices. material_slots: uint16[t], or None for slot 0 everywhere. normals: "
           "float32[m, 3], m being n for Domain.Vertex and 3 t for Domain.Corner, or None for flat shading. "
           "attributes: tuples (name, Domain, values), values being float32[m, c] with 1 to 4 components c. active_uv: "
           "the name of the UV map that is used if a node names none. texture_space_location and texture_space_size: "
           "the centre and half the extent of the box of Generated coordinates. Raises ValueError, which names the "
           "mesh, for an array of the wrong shape. Indices and lengths are checked when the scene is built.");
  def_mesh(module, "make_mesh", maker(mesh_arguments),
           "Make a mesh for any number of descriptions and return a MeshDescription for add_shared_mesh. Arguments and "
           "errors are those of SceneDescription.add_mesh.");
  def_strands(
      module, "make_strands", &make_strands,
      "Make hair and return a MeshDescription for add_shared_mesh. positions: float32[n, 3] in metres, the points of "
      "all strands. radii: float32[n] in metres. strands: uint32[s], the first point of each strand, ascending from 0. "
      "material_slots: uint16[s] or None. attributes: tuples (name, Domain, values), for points (Domain.Vertex) or "
      "strands (Domain.Face). subdivisions: 0 to 4, each segment of a ribbon has 2^subdivisions straight pieces. "
      "Raises ValueError, which names the strands, for an array of the wrong shape.");
  def_strands(scene, "add_strands", mesh_adder(&make_strands),
              "Add hair and return the index of its mesh. Arguments and errors are those of make_strands.");
  module.def("make_points", &make_points, py::kw_only(), py::arg("name"), py::arg("positions"), py::arg("radii"),
             py::arg("material_slots") = py::none(), py::arg("attributes") = std::vector<py::tuple>{},
             "Make a point cloud and return a MeshDescription for add_shared_mesh. positions: float32[n, 3] in metres. "
             "radii: float32[n] in metres; a point of radius 0 is invisible. material_slots: uint16[n] or None. "
             "attributes: tuples (name, Domain.Vertex, values) with one row for each point. Raises ValueError, which "
             "names the points, for an array of the wrong shape.");
  scene.def("add_points", mesh_adder(&make_points), py::kw_only(), py::arg("name"), py::arg("positions"),
            py::arg("radii"), py::arg("material_slots") = py::none(), py::arg("attributes") = std::vector<py::tuple>{},
            "Add a point cloud and return the index of its mesh. Arguments and errors are those of make_points.");
  module.def(
      "make_volume", &make_volume, py::kw_only(), py::arg("name"), py::arg("lower"), py::arg("upper"), py::arg("grids"),
      py::arg("density_in_object_space") = false, py::arg("flow") = py::none(),
      "Make a box that encloses grids and return a MeshDescription for add_shared_mesh. lower and upper: its "
      "corners in metres, object space. grids: tuples (name, index_from_object, bricks, values). "
      "index_from_object: 12 floats, three rows of four; voxel (i, j, k) has its centre at (i, j, k). bricks: "
      "int32[b, 3], the index of the first voxel of each brick of 8 x 8 x 8 voxels, divided by 8. values: "
      "float32[b, 8, 8, 8], or float32[b, 8, 8, 8, c] with c = 3 or 4 (a colour multiplied by alpha, and "
      "alpha), indexed by z, y and x of the voxel; voxels outside all "
      "bricks are 0. density_in_object_space: the volume keeps its optical depth when it is scaled. flow: None, or "
      "the name of a grid of velocities in object space, the factor by which the volume moves along them while "
      "the shutter is open, and the time in the shutter, from 0 to 1, at which the grids are as given. Raises "
      "ValueError, which names the volume, for an array of the wrong shape.");
  scene.def(py::init<>(), "Make one with default values.")
      .def("set_color_spaces", &set_color_spaces, py::arg("config"), py::arg("working_space"),
           "Set the meaning of all colours. config: the path of an OpenColorIO configuration, which gives the colour "
           "spaces of images their meaning. working_space: the name, in the configuration, of the linear space of all "
           "colours in the scene and of the rendered image; by default \"Linear Rec.709\".")
      .def("add_shared_mesh", &add_shared_mesh, py::arg("mesh"),
           "Add a mesh that make_mesh, make_strands, make_points or make_volume has made, without a copy, and return "
           "its "
           "index. Session.update keeps the structures of a mesh that the next description contains again.")
      .def(
          "add_object", &add_object, py::kw_only(), py::arg("name"), py::arg("mesh"),
          py::arg("materials") = std::vector<int>{}, py::arg("visibility") = uint32_t(kVisibleAll),
          py::arg("holdout") = false, py::arg("shadow_catcher") = false, py::arg("pass_index") = 0,
          py::arg("color") = Vec4(1.0f), py::arg("importance") = 1.0f, py::arg("shadow_terminator_offset") = 0.0f,
          py::arg("light_importance") = 1.0f, py::arg("properties") = std::vector<Property>{},
          py::arg("receiver_set") = 0, py::arg("blocker_set") = 0, py::arg("receivers") = LightLinks().receivers,
          py::arg("blockers") = LightLinks().blockers, py::arg("asset") = "", py::arg("light_group") = "",
          "Add an object and return its index. mesh: an index from add_mesh. materials: indices from add_material for "
          "the slots, -1 for the default grey. visibility: a sum of VISIBLE_* bits. properties: the values for "
          "Attribute nodes, tuples (name, whether the value belongs to the instancer, four numbers, column). Instances "
          "with a row of set_instance_values have the value of this column there instead; -1: none has. "
          "receiver_set, blocker_set: the sets of objects for light linking and for shadow linking, below "
          "RECEIVER_SETS and BLOCKER_SETS. receivers, "
          "blockers: bit s says whether the light that the object emits lights objects of receiver set s, and whether "
          "objects of blocker set s block it. The other "
          "arguments are the fields of ObjectDescription. Indices are checked when the scene is built.")
      .def("add_instances", &add_instances, py::arg("objects"), py::arg("world_from_object"),
           py::arg("random") = py::none(),
           "Add n instances. objects: int32[n], indices from add_object. world_from_object: float32[n, 12], three rows "
           "of four of each affine transform, lengths in metres. random: float32[n] in 0 to 1 for Object Info > "
           "Random, or None for 0. Raises ValueError for an array of the wrong shape or length.")
      .def("set_origins", &set_origins, py::arg("instances"), py::arg("values"),
           "Set what m instances have from the instancers that placed them. instances: int32[m], numbers in the order "
           "of add_instances. values: float32[m, 18]: Generated coordinates and UV on the instancer (3, 2); of the "
           "particle, index, age and lifetime in frames, size, location, velocity and angular velocity (1, 1, 1, 1, 3, "
           "3, 3). Raises ValueError for an array of the wrong shape or length, and IndexError for an instance that "
           "does not exist.")
      .def(
          "set_instance_values", &set_instance_values, py::arg("instances"), py::arg("columns"), py::arg("values"),
          "Set the values that Attribute nodes read from the instancer for m instances that have values of their own. "
          "instances: int32[m], numbers in the order of add_instances. values: float32[m, 4 * columns]; the properties "
          "of add_object say which column a name has. Raises ValueError for an array of the wrong shape or length or "
          "for another number of columns than before, and IndexError for an instance that does not exist.")
      .def("set_motion", &set_motion, py::arg("instances"), py::arg("world_from_object"),
           "Set the transforms of m moving instances at k evenly spaced times while the shutter is open. instances: "
           "int32[m], numbers in the order of add_instances. world_from_object: float32[m, k, 12], k from 2 to 129. "
           "Raises ValueError when the second array is not a whole number of transforms for each instance, and "
           "IndexError for an instance that does not exist.")
      .def(
          "set_frames", &set_frames, py::arg("instances"), py::arg("world_from_object"),
          "Set the transforms of m instances one frame before and one after, for the pass Vector. instances: int32[m], "
          "numbers in the order of add_instances. world_from_object: float32[m, 2, 12]. Raises ValueError for another "
          "size, and IndexError for an instance that does not exist.")
      .def("set_vertex_attribute", &set_vertex_attribute, py::arg("mesh"), py::arg("name"), py::arg("values"),
           "Add an attribute to the vertices of a mesh. A shared mesh is copied first. values: float32[n, 3]. Raises "
           "ValueError for "
           "another number of vertices, and IndexError for a mesh that does not exist.")
      .def(
          "set_shapes", &set_shapes, py::arg("mesh"), py::arg("positions"), py::arg("normals") = py::none(),
          py::arg("radii") = py::none(),
          "Set the shapes of a mesh at k evenly spaced times while the shutter is open. positions: float32[k, n, 3] "
          "for "
          "n vertices. normals: float32[k, m, 3] for m normals of the mesh, or None to keep them. radii: float32[k, n] "
          "of strands or points, or None to keep them. k is from 2 to 129. A shared mesh is copied first. Raises "
          "ValueError for other numbers of values, and IndexError for a mesh that does not exist.")
      .def("add_image", &add_image, py::kw_only(), py::arg("name"), py::arg("path") = "",
           py::arg("packed") = py::bytes(), py::arg("pixels") = py::none(), py::arg("width") = 0, py::arg("height") = 0,
           py::arg("color_space") = "sRGB", py::arg("alpha_mode") = AlphaMode::Straight, py::arg("size_limit") = 0,
           py::arg("resolution") = 1.0f,
           "Add an image and return its index. It has one source. path: a file. packed: the bytes of a file. pixels: "
           "float32[height, width, 4] or flat, RGBA, rows from the bottom up, with width and height in pixels. Raises "
           "ValueError, which names the image, when pixels does not have width * height * 4 numbers. An image that "
           "cannot be read renders magenta and is reported by name. The texture is halved until its longer side has at "
           "most size_limit texels (0: no limit) and its sides at most the fraction `resolution` of those of the "
           "image.")
      .def("add_tiled_image", &add_tiled_image, py::arg("name"), py::arg("tiles"),
           "Add an image of tiles and return its index. tiles: tuples (number, index of an image without tiles). Tile "
           "1001 + u + 10 v covers the square from (u, v) to (u + 1, v + 1), u being 0 to 9. Places without a tile are "
           "magenta.")
      .def(
          "add_material",
          [](SceneDescription& description, std::string name, const NodeGraph& graph, int pass_index,
             DisplacementMethod displacement_method, bool transparent_shadow, bool bump_map_correction) {
            description.materials.push_back(
                {std::move(name), graph, pass_index, displacement_method, transparent_shadow, bump_map_correction});
            return index_of_last(description.materials.size());
          },
          py::kw_only(), py::arg("name"), py::arg("graph"), py::arg("pass_index") = 0,
          py::arg("displacement_method") = DisplacementMethod::Bump, py::arg("transparent_shadow") = true,
          py::arg("bump_map_correction") = true,
          "Add a material and return its index. The graph is copied. Links are checked when the scene is built. "
          "transparent_shadow: whether shadow rays pass its transparent parts. bump_map_correction: whether light "
          "fades "
          "softly where a bump faces it and the surface does not.")
      .def(
          "add_light",
          [](SceneDescription& description, const LightDescription& light) {
            description.lights.push_back(light);
            return index_of_last(description.lights.size());
          },
          py::arg("light"),
          "Add a copy of a lamp and return its index. A lamp with values that are not finite is left out, with a "
          "message, when the scene is built.")
      .def(
          "add_hint",
          [](SceneDescription& description, std::string name, const Floats& points, float spread,
             std::vector<float> spreads, float weight, bool enabled) {
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
          py::kw_only(), py::arg("name"), py::arg("points"), py::arg("spread") = 0.0872665f,
          py::arg("spreads") = std::vector<float>(), py::arg("weight") = 1.0f, py::arg("enabled") = true,
          "Add a light hint and return its index. points: float32[n, 3] in metres, world space, from a light towards "
          "what the camera sees, n >= 2. spread: the half-angle of the cone around each of the n - 1 segments, "
          "radians, > 0 to pi. spreads: the half-angles of the first segments. weight: >= 0, relative to other hints. "
          "Raises ValueError, which names the hint, when points has the wrong shape. A hint that cannot be attached is "
          "reported and not used.")
      .def_property_readonly("meshes", &meshes_of, "list of MeshDescription. Copies of the meshes.")
      .def_readonly("objects", &SceneDescription::objects, "list of ObjectDescription. Copies of the objects.")
      .def_readonly("instances", &SceneDescription::instances, "list of InstanceDescription. Copies of the instances.")
      .def_readonly("materials", &SceneDescription::materials, "list of MaterialDescription. Copies of the materials.")
      .def_readonly("images", &SceneDescription::images, "list of ImageDescription. Copies of the images.")
      .def_readwrite("hints", &SceneDescription::hints,
                     "list of HintDescription. Copies of the light hints; a list that is assigned replaces them.")
      .def_readonly("lights", &SceneDescription::lights, "list of LightDescription. Copies of the lamps.")
      .def_readwrite("world", &SceneDescription::world,
                     "WorldDescription. The world. Changes of its fields apply to this description.")
      .def_readonly(
          "motion_keys", &SceneDescription::motion_keys,
          "list of lists of 12 floats. The transforms of all moving instances, one instance after the other. A copy.")
      .def_readwrite("dicing", &SceneDescription::dicing,
                     "DicingDescription. What adaptive subdivision follows. Changes of its fields apply to this "
                     "description.")
      .def_readwrite("camera", &SceneDescription::camera,
                     "CameraDescription. The camera. Changes of its fields apply to this description.")
      .def_readwrite("settings", &SceneDescription::settings,
                     "RenderSettings. The settings. Changes of its fields apply to this description.")
      .def("fingerprint", py::overload_cast<const SceneDescription&>(&fingerprint),
           py::call_guard<py::gil_scoped_release>(),
           "Return a 64-bit hash of everything except the camera and the settings. The settings of caustics and of the "
           "bump terminator are included. Descriptions with equal hashes give equal images with the same camera. "
           "Shared meshes are hashed by identity.");

  module.def(
      "random_per_island",
      [](size_t vertex_count, const Array<uint32_t>& edges) {
        const auto pairs = copy_rows<MeshEdge>(edges, "edges");
        std::vector<float> random;
        {
          py::gil_scoped_release release;
          random = random_per_island(vertex_count, pairs);
        }
        return to_array<float>(random);
      },
      py::arg("vertex_count"), py::arg("edges"),
      "Return float32[vertex_count]: a random number in 0 to 1 for each vertex, the same for all connected vertices, "
      "as in Cycles. edges: uint32[e, 2] of vertices; edges with invalid vertices are ignored. Raises ValueError for "
      "an array of the wrong shape.");
  module.def(
      "pointiness",
      [](const Floats& positions, const Floats& normals, const Array<uint32_t>& edges) {
        const auto places = copy_rows<Vec3>(positions, "positions"), directions = copy_rows<Vec3>(normals, "normals");
        const auto pairs = copy_rows<MeshEdge>(edges, "edges");
        std::vector<float> found;
        {
          py::gil_scoped_release release;
          found = pointiness(places, directions, pairs);
        }
        return to_array<float>(found);
      },
      py::arg("positions"), py::arg("normals"), py::arg("edges"),
      "Return float32[n]: the pointiness of each vertex, 0 to 1, 0.5 where the mesh is flat, as in Cycles. positions "
      "and normals: float32[n, 3]. edges: uint32[e, 2] of vertices. Raises ValueError for an array of the wrong "
      "shape.");
  module.def(
      "uv_tangents",
      [](const Floats& positions, const Array<uint32_t>& triangles, const Floats& normals, const OptionalFloats& uvs) {
        const auto places = copy_rows<Vec3>(positions, "positions"), directions = copy_rows<Vec3>(normals, "normals");
        const auto corners = copy_rows<UVec3>(triangles, "triangles");
        const auto coordinates = uvs ? copy_rows<Vec2>(*uvs, "uvs") : std::vector<Vec2>();
        const size_t count = 3 * corners.size();
        if (directions.size() != count || (uvs && coordinates.size() != count))
          throw py::value_error("normals and uvs must have three rows for each triangle");
        for (const UVec3& triangle : corners)
          if (std::max({triangle.x, triangle.y, triangle.z}) >= places.size())
            throw py::value_error("triangles refer to positions that do not exist");
        std::vector<Vec4> found;
        {
          py::gil_scoped_release release;
          found = uv_tangents(places, corners, directions, coordinates);
        }
        return to_array<float>(found);
      },
      py::arg("positions"), py::arg("triangles"), py::arg("normals"), py::arg("uvs") = py::none(),
      "Return float32[3 t, 4]: for each corner of t triangles the tangent along u of a UV map, in object space, and "
      "the "
      "sign of the bitangent, as in Cycles. positions: float32[n, 3]. triangles: uint32[t, 3]. normals: float32[3 t, "
      "3], "
      "of corners. uvs: float32[3 t, 2]; None: coordinates on a sphere. The attribute `TANGENT_OF` + name of the UV "
      "map "
      "(Domain.Corner), or without a name for the active one, gives them to the nodes. Raises ValueError for an array "
      "of "
      "the wrong shape.");
  module.def("save_description", &save_description, py::arg("description"), py::arg("path"),
             py::call_guard<py::gil_scoped_release>(),
             "Write a description to a file. Raises SceneError, which names the file, when it cannot be written.");
  module.def("load_description", &load_description, py::arg("path"), py::call_guard<py::gil_scoped_release>(),
             "Read a description from a file. Files of older versions are read. Raises SceneError when the file cannot "
             "be read, is damaged, or is not a scene file.");
}

}  // namespace ajar::python
