#include "render/session_state.h"

#include <nlohmann/json.hpp>

#include "platform/platform.h"
#include "shading/images/tile_cache.h"

namespace ajar {

namespace {

using nlohmann::json;

const char* name_of(Progress::Phase phase) {
  switch (phase) {
    case Progress::Phase::Idle: return "idle";
    case Progress::Phase::Building: return "building";
    case Progress::Phase::Rendering: return "rendering";
    case Progress::Phase::Done: return "done";
    case Progress::Phase::Cancelled: return "cancelled";
    case Progress::Phase::Failed: return "failed";
  }
  return "";
}

const char* name_of(Bias bias) {
  switch (bias) {
    case Bias::Unbiased: return "unbiased";
    case Bias::Consistent: return "consistent";
    case Bias::Biased: return "biased";
  }
  return "";
}

/// What was rendered, how, and how long it took.
void add_render(const SessionState& d, json& j) {
  j["version"] = AJAR_VERSION;
  j["state"] = name_of(d.progress.phase);
  j["integrator"] = d.integrator_name;
  if (d.mixture)
    for (size_t k = 0; k < d.mixture->parts().size(); ++k)
      j["techniques"].push_back({{"integrator", d.mixture->choice().techniques[k].integrator},
                                 {"bias", name_of(d.mixture->parts()[k].integrator.bias())},
                                 {"share_of_work", d.mixture->choice().techniques[k].share},
                                 {"samples_per_pixel", d.mixture->parts()[k].done}});
  j["direct"] = name_of(d.settings.direct);
  j["guiding"] = name_of(d.settings.guiding);
  j["vertex_merging"] = name_of(d.settings.vertex_merging);
  j["image"] = name_of(d.settings.image);
  j["seeds"] = d.base ? d.base->seeds : std::vector<uint32_t>{};
  if (d.film) j["seeds"].push_back(d.seed);
  if (d.range) j["first_sample"] = d.range->first;
  if (const auto& before = d.base ? d.base : d.continued)
    j["resumed"] = {{"samples", before->samples},
                    {"seconds", before->seconds},
                    {"rays", before->rays},
                    {"refused_samples", before->refused}};
  j["threads"] = d.threads;
  j["frames_before"] = d.learned ? d.learned->frames : 0;
  j["resolution"] = {d.settings.width, d.settings.height};
  j["build_seconds"] = d.progress.build_seconds;
  j["pilot_seconds"] = d.pilot_seconds;
  j["render_seconds"] = d.progress.render_seconds;
  j["render_cpu_seconds"] = d.cpu_seconds;
  j["peak_memory_bytes"] = platform::peak_memory_bytes();
  j["rays"] = d.statistics.rays;
  j["paths"] = d.statistics.paths;
  if (d.progress.render_seconds > 0.0) {
    j["rays_per_second"] = double(d.statistics.rays) / d.progress.render_seconds;
  }
}

/// Counts of the integrator, samples, and the bias of the image.
void add_samples(const SessionState& d, json& j) {
  for (const auto& [key, value] : d.statistics.extra) j[key] = value;
  if (d.film) {
    const Film::SampleCounts& counts = d.sample_counts;
    j["samples_per_pixel"] = {{"mean", d.samples_before() + counts.mean}, {"min", counts.min}, {"max", counts.max}};
    j["refused_samples"] = d.refused;
    j["film_bytes"] = d.film_bytes;
  }
  if (d.integrator) {
    Bias bias = d.integrator->bias();
    if (d.mixture) bias = Bias::Consistent;
    j["bias"] = name_of(d.image_plan && d.integrator->goal_support().learns ? std::max(bias, Bias::Consistent) : bias);
  }
}

/// The built scene.
void add_scene(const SessionState& d, json& j) {
  if (d.scene) {
    const BuildStatistics& b = d.scene->statistics();
    j["scene"] = {{"triangles", b.triangles},
                  {"strands", b.strands},
                  {"points", b.points},
                  {"instanced_triangles", b.instanced_triangles},
                  {"instances", b.instances},
                  {"meshes", b.meshes},
                  {"lights", b.lights},
                  {"geometry_bytes", b.geometry_bytes},
                  {"accel_bytes", b.accel_bytes},
                  {"texture_bytes", b.texture_bytes},
                  {"light_tree_bytes", b.light_tree_bytes},
                  {"environment_bytes", b.environment_bytes},
                  {"skipped_triangles", b.skipped_triangles},
                  {"repaired_values", b.repaired_values},
                  {"kept_meshes", b.kept_meshes},
                  {"kept_textures", b.kept_textures},
                  {"tiled_textures", b.tiled_textures},
                  {"made_textures", b.made_textures},
                  {"compiled_programs", b.compiled_programs},
                  {"kept_programs", b.kept_programs},
                  {"placed_instances", b.placed_instances},
                  {"kept_environment", b.kept_environment}};
    const TileStatistics t = d.scene->textures().tile_statistics();
    if (b.tiled_textures > 0)
      j["texture_cache"] = {{"limit_bytes", t.limit_bytes},
                            {"peak_bytes", t.peak_bytes},
                            {"tiles_read", t.tiles_read},
                            {"bytes_read", t.bytes_read},
                            {"failed_tiles", t.failed_tiles}};
  }
}

/// Light hints: how they were attached, and their contribution.
void add_hints(const SessionState& d, json& j) {
  j["hints"] = json::array();
  for (const HintStatistics& hint : d.statistics.hints) {
    const HintReport& r = hint.report;
    json positions = json::array(), segments = json::array();
    for (const Vec3& p : r.positions) positions.push_back({p.x, p.y, p.z});
    for (const HintSegmentState state : r.segments)
      segments.push_back(state == HintSegmentState::Attached  ? "attached"
                         : state == HintSegmentState::Bounced ? "bounced"
                                                              : "failed");
    j["hints"].push_back({{"name", r.name},
                          {"attached", r.attached},
                          {"reason", r.reason},
                          {"proposed", hint.proposed},
                          {"accepted", hint.accepted},
                          {"energy_share", hint.energy_share},
                          {"positions", std::move(positions)},
                          {"segments", std::move(segments)}});
  }
}

/// Acceptance rates of mutations.
void add_acceptance_rates(const SessionState& d, json& j) {
  j["acceptance_rates"] = json::object();
  for (const auto& [key, proposed] : d.statistics.extra) {
    if (!key.starts_with("proposed_") || !(proposed > 0.0)) continue;
    const auto accepted = d.statistics.extra.find("accepted_" + key.substr(9));
    if (accepted != d.statistics.extra.end()) j["acceptance_rates"][key.substr(9)] = accepted->second / proposed;
  }
}

/// Estimates of the error over time.
void add_errors(const SessionState& d, json& j) {
  if (d.progress.denoised_relmse >= 0.0) j["denoised_relmse"] = d.progress.denoised_relmse;
  j["estimated_error"] = json::array();
  j["estimated_perceptual_error"] = json::array();
  for (const ErrorPoint& point : d.error_over_time) {
    j["estimated_error"].push_back({point.seconds, point.samples, point.relmse});
    j["estimated_perceptual_error"].push_back({point.seconds, point.samples, point.perceptual});
  }
}

/// Messages for the artist.
void add_diagnostics(const SessionState& d, json& j) {
  j["diagnostics"] = json::array();
  for (const Diagnostic& diagnostic : diagnostics_of(d)) {
    const char* severity = diagnostic.severity == Diagnostic::Severity::Info      ? "info"
                           : diagnostic.severity == Diagnostic::Severity::Warning ? "warning"
                                                                                  : "error";
    j["diagnostics"].push_back(
        {{"severity", severity}, {"object", diagnostic.object}, {"message", diagnostic.message}});
  }
}

}  // namespace

Diagnostics diagnostics_of(const SessionState& d) {
  Diagnostics all = d.diagnostics;
  if (!d.scene) return all;
  if (const TileStatistics t = d.scene->textures().tile_statistics(); t.failed_tiles > 0)
    report_once(all, {Diagnostic::Severity::Warning, "Texture Cache",
                      "'" + t.failed_file + "' is damaged, and places on its surfaces are magenta. " +
                          (t.removed ? "The file was removed; render again" : "Delete the file")});
  return all;
}

std::string statistics_json(const SessionState& d) {
  json j;
  add_render(d, j);
  add_samples(d, j);
  add_scene(d, j);
  j["plan"] = json::array();
  for (const PlanStep& step : d.plan)
    j["plan"].push_back({{"step", step.step}, {"used", step.used}, {"reason", step.reason}, {"cost", step.cost}});
  add_hints(d, j);
  add_acceptance_rates(d, j);
  add_errors(d, j);
  add_diagnostics(d, j);
  // Names can contain bytes that are not UTF-8. They are replaced and are not an error.
  return j.dump(1, ' ', false, json::error_handler_t::replace);
}

}  // namespace ajar
