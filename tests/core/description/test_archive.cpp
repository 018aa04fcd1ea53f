#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>

#include "description/archive.h"
#include "math/random.h"
#include "scene_fixtures.h"

namespace ajar::test_archive {

namespace {

SceneDescription rich_description() {
  SceneDescription d;
  const int material = fixtures::add_diffuse(d, Color(0.5f), Color(1.0f, 0.0f, 0.25f));
  MeshDescription mesh = fixtures::sphere(4);
  mesh.attributes.push_back({"UVMap", Domain::Corner, 2, std::vector<float>(mesh.triangles.size() * 6, 0.25f)});
  mesh.material_slots.assign(mesh.triangles.size(), 0);
  fixtures::add_object(d, mesh, material);
  fixtures::set_camera(d, Vec3(0, -4, 0), Vec3(0), 32);
  d.lights.push_back(fixtures::point_light(Vec3(0, 0, 3), 100.0f, 0.1f));
  ImageDescription image;
  image.name = "Bild";
  image.packed = {1, 2, 3};
  d.images.push_back(image);
  d.materials[0].graph.nodes[0].properties.push_back({"distribution", "GGX", {1.0f, 2.0f}});
  return d;
}

/// The same with data that only newer versions of the file format have.
SceneDescription hairy_description() {
  SceneDescription d = rich_description();
  MeshDescription mesh = fixtures::hair({{{0, 0, 0}, {0, 0, 1}, {0, 1, 2}}, {{1, 0, 0}, {1, 0, 2}}}, 0.1f, 0.05f,
                                        StrandShape::Round);
  mesh.strand_subdivisions = 3;
  mesh.attributes.push_back({"UVMap", Domain::Face, 2, {0.0f, 0.25f, 0.5f, 0.75f}});
  mesh.material_slots = {0, 1};
  fixtures::add_object(d, mesh, 0);
  return d;
}

}  // namespace

TEST(Archive, round_trip_keeps_every_byte) {
  const SceneDescription d = rich_description();
  const std::vector<char> bytes = to_bytes(d);
  const SceneDescription again = from_bytes(bytes);
  EXPECT_EQ(to_bytes(again), bytes);
  EXPECT_EQ(again.meshes.at(0).attributes.at(0).name, "UVMap");
  EXPECT_EQ(again.materials.at(0).graph.nodes.at(0).properties.at(0).text, "GGX");
  EXPECT_EQ(again.lights.at(0).radius, 0.1f);
}

TEST(Archive, values_of_instances_are_kept_since_version_r) {
  SceneDescription d = rich_description(), before = rich_description();
  d.objects[0].properties = before.objects[0].properties = {{"shade", true, Vec4(1)}};
  d.objects[0].properties[0].column = 0;
  d.instance_values = {1, {{1, 2, 3, 4}}};
  d.instances[0].values = 0;
  EXPECT_EQ(to_bytes(from_bytes(to_bytes(d))), to_bytes(d));
  EXPECT_EQ(to_bytes(from_bytes(to_bytes(d, 'Q'))), to_bytes(before));
  EXPECT_NE(fingerprint(d), fingerprint(before));
}

TEST(Archive, what_instances_have_from_instancers_is_kept_since_version_f) {
  SceneDescription d = rich_description();
  d.instance_origins.push_back({{1, 2, 3}, {4, 5}, 6, 7, 8, 9, {10, 11, 12}, {13, 14, 15}, {16, 17, 18}});
  d.instances[0].origin = 0;
  EXPECT_EQ(to_bytes(from_bytes(to_bytes(d))), to_bytes(d));
  EXPECT_EQ(to_bytes(from_bytes(to_bytes(d, 'E'))), to_bytes(rich_description()));
  EXPECT_NE(fingerprint(d), fingerprint(rich_description()));
}

TEST(Archive, files_of_older_versions_are_read_with_defaults) {
  const SceneDescription d = rich_description();
  SceneDescription panorama = d, moving = d;  // data that files before version 4, 5, 6, 7, 8, 9 and A lack
  panorama.camera.panorama.fisheye_fov = 3.0f;
  moving.motion_keys = {d.camera.world_from_camera};
  moving.camera.shutter = {0.0f, 1.0f};
  moving.settings.mist.depth = 3.0f;
  SceneDescription limited = d;
  limited.settings.memory_limit = 1000;
  SceneDescription important = d;
  important.lights[0].light_importance = important.objects[0].light_importance = important.world
                                                                                     .light_importance = 2.0f;
  SceneDescription guided = d;
  guided.settings.guiding = Guiding::On;
  SceneDescription hairy = hairy_description(), bald = hairy;
  bald.meshes.back().strands.clear();
  bald.meshes.back().radii.clear();
  bald.meshes.back().strand_shape = StrandShape::Ribbon;
  bald.meshes.back().strand_subdivisions = 2;
  EXPECT_EQ(to_bytes(from_bytes(to_bytes(hairy))), to_bytes(hairy));
  for (char version = '2'; version <= 'A'; version = version == '9' ? 'A' : char(version + 1))
    EXPECT_EQ(to_bytes(from_bytes(to_bytes(hairy, version))), to_bytes(bald));
  SceneDescription merging = d;
  merging.settings.vertex_merging = Merging::On;
  const auto written = to_bytes(d);
  EXPECT_EQ(to_bytes(from_bytes(to_bytes(panorama))), to_bytes(panorama));
  EXPECT_EQ(to_bytes(from_bytes(to_bytes(moving))), to_bytes(moving));
  EXPECT_NE(to_bytes(panorama), written);
  EXPECT_NE(to_bytes(moving), written);
  for (char version = '2'; version < '4'; ++version)
    EXPECT_EQ(to_bytes(from_bytes(to_bytes(panorama, version))), written);
  for (char version = '2'; version < '5'; ++version)
    EXPECT_EQ(to_bytes(from_bytes(to_bytes(guided, version))), written);
  for (char version = '2'; version < '6'; ++version)
    EXPECT_EQ(to_bytes(from_bytes(to_bytes(moving, version))), written);
  for (char version = '2'; version < '7'; ++version)
    EXPECT_EQ(to_bytes(from_bytes(to_bytes(merging, version))), written);
  EXPECT_NE(to_bytes(from_bytes(to_bytes(merging))), written);
  EXPECT_EQ(to_bytes(from_bytes(to_bytes(limited))), to_bytes(limited));
  EXPECT_NE(to_bytes(limited), written);
  for (char version = '2'; version < '8'; ++version)
    EXPECT_EQ(to_bytes(from_bytes(to_bytes(limited, version))), written);
  EXPECT_EQ(to_bytes(from_bytes(to_bytes(important))), to_bytes(important));
  EXPECT_NE(to_bytes(important), written);
  for (char version = '2'; version < '9'; ++version)
    EXPECT_EQ(to_bytes(from_bytes(to_bytes(important, version))), written);
  SceneDescription bumped = d;
  bumped.settings.bump_terminator = BumpTerminator::Microfacet;
  EXPECT_EQ(from_bytes(to_bytes(bumped)).settings.bump_terminator, BumpTerminator::Microfacet);
  for (char version : {'2', '9', 'A', 'B'}) EXPECT_EQ(to_bytes(from_bytes(to_bytes(bumped, version))), written);
  SceneDescription wide = d;
  wide.color = {"config.ocio", "ACEScg"};
  wide.images[0].tiles = {{1001, 0}, {1012, 1}};
  EXPECT_EQ(from_bytes(to_bytes(wide)).color, wide.color);
  EXPECT_EQ(from_bytes(to_bytes(wide)).images[0].tiles, wide.images[0].tiles);
  for (char version : {'2', '9', 'A', 'D'}) EXPECT_EQ(to_bytes(from_bytes(to_bytes(wide, version))), written);
  SceneDescription soft = d;
  soft.lights[0].soft_falloff = soft.lights[0].even_spot = true;
  EXPECT_EQ(to_bytes(from_bytes(to_bytes(soft))), to_bytes(soft));
  for (char version : {'2', '9', 'A', 'D'}) EXPECT_EQ(to_bytes(from_bytes(to_bytes(soft, version))), written);
  SceneDescription even = d;
  even.lights[0].even_sun = true;
  EXPECT_EQ(to_bytes(from_bytes(to_bytes(even))), to_bytes(even));
  for (char version : {'2', '9', 'A', 'O'}) EXPECT_EQ(to_bytes(from_bytes(to_bytes(even, version))), written);
  SceneDescription placed = d;
  placed.lights[0].has_uv = placed.lights[0].own_coordinates = true;
  EXPECT_EQ(to_bytes(from_bytes(to_bytes(placed))), to_bytes(placed));
  for (char version : {'2', 'O', 'R'}) EXPECT_EQ(to_bytes(from_bytes(to_bytes(placed, version))), written);
  SceneDescription linked = d;
  linked.objects[0].receiver_set = 3;
  linked.objects[0].blocker_set = 4;
  linked.objects[0].links = {5, 6};
  linked.lights[0].links = {7, 8};
  linked.lights[0].max_bounces = 9;
  linked.world.max_bounces = 10;
  const SceneDescription read = from_bytes(to_bytes(linked));
  EXPECT_EQ(read.objects[0].receiver_set, 3);
  EXPECT_EQ(read.objects[0].blocker_set, 4);
  EXPECT_EQ(read.objects[0].links, linked.objects[0].links);
  EXPECT_EQ(read.lights[0].links, linked.lights[0].links);
  EXPECT_EQ(read.lights[0].max_bounces, 9);
  EXPECT_EQ(read.world.max_bounces, 10);
  for (char version : {'2', '9', 'A', 'I'}) EXPECT_EQ(to_bytes(from_bytes(to_bytes(linked, version))), written);
  SceneDescription named = d;
  named.objects[0].properties = {{"tint", true, Vec4(1, 2, 3, 4)}};
  EXPECT_EQ(from_bytes(to_bytes(named)).objects[0].properties.at(0).value, Vec4(1, 2, 3, 4));
  EXPECT_EQ(to_bytes(from_bytes(to_bytes(named))), to_bytes(named));
  for (char version = '2'; version <= '9'; ++version)
    EXPECT_EQ(to_bytes(from_bytes(to_bytes(named, version))), written);
  SceneDescription grouped = d;
  grouped.objects[0].asset = grouped.lights[0].light_group = grouped.world.light_group = "Group";
  grouped.instances[0].first_frame_key = 0;
  grouped.camera.frames = {d.camera.world_from_camera, d.camera.world_from_camera};
  grouped.settings.ao_distance = 2.0f;
  EXPECT_EQ(to_bytes(from_bytes(to_bytes(grouped))), to_bytes(grouped));
  EXPECT_NE(to_bytes(grouped), written);
  for (char version : {'2', '9', 'A', 'H'}) EXPECT_EQ(to_bytes(from_bytes(to_bytes(grouped, version))), written);
  SceneDescription stereo = d;
  stereo.images[0].size_limit = 128;
  stereo.images[0].resolution = 0.5f;
  stereo.camera.stereo = {0.1f, 2.0f, 0.5f, 1.0f};
  EXPECT_EQ(from_bytes(to_bytes(stereo)).camera.stereo, stereo.camera.stereo);
  EXPECT_EQ(to_bytes(from_bytes(to_bytes(stereo))), to_bytes(stereo));
  EXPECT_NE(to_bytes(stereo), written);
  for (char version : {'2', '9', 'A', 'L'}) EXPECT_EQ(to_bytes(from_bytes(to_bytes(stereo, version))), written);
  std::vector<char> bytes = to_bytes(d);
  bytes[7] = '1';
  EXPECT_THROW(from_bytes(bytes), SceneError);
}

TEST(Archive, truncated_files_are_refused_at_every_length) {
  const std::vector<char> bytes = to_bytes(rich_description());
  for (size_t length = 0; length < bytes.size(); length += 1 + length / 50)
    EXPECT_THROW(from_bytes(std::vector<char>(bytes.begin(), bytes.begin() + std::ptrdiff_t(length))), SceneError)
        << length;
}

/// A count must not allocate more memory than the rest of the file can fill. This count would allocate a mesh of about
/// 300 bytes for each remaining byte of the file.
TEST(Archive, lists_longer_than_the_file_are_refused_before_memory_is_allocated) {
  std::vector<char> bytes = to_bytes(SceneDescription{});
  bytes.resize(16);
  bytes.resize(1 << 16, 0);
  const uint64_t meshes = bytes.size() - 16;
  std::memcpy(bytes.data() + 8, &meshes, sizeof meshes);
  try {
    from_bytes(bytes);
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_STREQ(error.what(),
                 "The scene file is damaged.");  // reading the meshes would give "ends too early"
  }
  // Lists of empty elements are read: the reader's minimum size of an element is not too large.
  SceneDescription empty;
  empty.meshes.resize(1000);
  empty.materials.resize(1000);
  empty.materials[0].graph.nodes.resize(1000);
  empty.images.resize(1000);
  for (ImageDescription& image : empty.images) image.color_space.clear();
  empty.lights.resize(1000);
  empty.hints.resize(1000);
  for (char version : {'2', '9', 'A', 'B', 'C', 'D', 'E'})
    EXPECT_EQ(to_bytes(from_bytes(to_bytes(empty, version))), to_bytes(empty));
}

TEST(Archive, flipped_bytes_never_crash_the_reader_or_the_build) {
  const std::vector<char> bytes = to_bytes(hairy_description());
  Pcg32 rng(1);
  int survived = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<char> damaged = bytes;
    for (int k = 0; k < 3; ++k) damaged[rng.next() % damaged.size()] = char(rng.next());
    try {
      fixtures::build(from_bytes(damaged));
      ++survived;
    } catch (const SceneError&) {
    }
  }
  EXPECT_GT(survived, 0);
}

TEST(Archive, missing_file_names_the_path) {
  try {
    load_description("/nonexistent/x.ajar");
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("/nonexistent/x.ajar"), std::string::npos);
  }
}

TEST(Archive, folders_and_devices_are_refused) {
  EXPECT_THROW(load_description(std::filesystem::temp_directory_path().string()), SceneError);
#ifdef _WIN32
  EXPECT_THROW(load_description("NUL"), SceneError);
#else
  EXPECT_THROW(load_description("/dev/null"), SceneError);
#endif
}

TEST(Archive, shared_meshes_are_written_like_other_meshes) {
  const SceneDescription d = rich_description();
  SceneDescription sharing = d;
  sharing.meshes[0] = {};
  sharing.meshes[0].shared = std::make_shared<MeshDescription>(d.meshes[0]);
  EXPECT_EQ(to_bytes(sharing), to_bytes(d));
}

TEST(Archive, the_fingerprint_changes_with_the_scene_and_not_with_the_view) {
  const SceneDescription d = rich_description();
  const uint64_t before = fingerprint(d);
  const auto changed = [&](auto change) {
    SceneDescription copy = d;
    change(copy);
    return fingerprint(copy) != before;
  };
  EXPECT_FALSE(changed([](auto&) {}));
  EXPECT_FALSE(changed([](auto& c) {
    c.camera.clip_end = 7.0f;
    c.settings.width = 3;
  }));
  EXPECT_TRUE(changed([](auto& c) { c.instances[0].world_from_object[3] += 1e-6f; }));
  EXPECT_TRUE(changed([](auto& c) { c.materials[0].graph.nodes[0].inputs[0].value.x = 0.75f; }));
  EXPECT_TRUE(changed([](auto& c) { c.lights[0].energy += 1.0f; }));
  EXPECT_TRUE(changed([](auto& c) { c.meshes[0].positions[0].x += 1.0f; }));
  EXPECT_TRUE(changed([](auto& c) { c.world.color.x += 1.0f; }));
  EXPECT_TRUE(changed([](auto& c) { c.images[0].packed.push_back(0); }));
  EXPECT_TRUE(changed([](auto& c) { c.hints.push_back({}); }));
}

}  // namespace ajar::test_archive
