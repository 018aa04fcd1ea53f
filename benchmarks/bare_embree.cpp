// bare_embree SCENE.ajar [--samples N] [--threads N] [--repeats N] Measures the ray rate of the path tracer as a
// fraction of that of Embree alone. The ray queries of the path tracer are recorded once: the linker redirects its
// calls of rtcIntersect1 and rtcOccluded1 to the two functions below (-Wl,--wrap), so that the engine needs no hook.
// Then two programs are timed in turn, with the same number of threads in one process: the path tracer, and a loop that
// only traces the recorded rays in their order, on the structure of the engine and on one with Embree's default flags
// (the engine uses robust traversal). Both rates are recorded rays divided by seconds, so that the fraction is the
// ratio of the times. Queries for lamps are part of the time of the engine, but not of the loop. Prints one JSON
// object.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <nlohmann/json.hpp>

#include "description/archive.h"
#include "integrators/integrator.h"
#include "scene/embree.h"

namespace {

struct Query {
  RTCScene scene;
  RTCRay ray;
  bool any_hit, coherent;
};
std::vector<Query>* recording = nullptr;  // written by one thread only
bool default_flags = false;               // builds with Embree's default scene flags

}  // namespace

extern "C" {
void __real_rtcSetSceneFlags(RTCScene scene, RTCSceneFlags flags);
void __wrap_rtcSetSceneFlags(RTCScene scene, RTCSceneFlags flags) {
  __real_rtcSetSceneFlags(scene, default_flags ? RTC_SCENE_FLAG_NONE : flags);
}

#if AJAR_EMBREE_MAJOR >= 4
void __real_rtcIntersect1(RTCScene scene, RTCRayHit* query, RTCIntersectArguments* arguments);
void __wrap_rtcIntersect1(RTCScene scene, RTCRayHit* query, RTCIntersectArguments* arguments) {
  if (recording)
    recording->push_back({scene, query->ray, false, arguments && (arguments->flags & RTC_RAY_QUERY_FLAG_COHERENT)});
  __real_rtcIntersect1(scene, query, arguments);
}
void __real_rtcOccluded1(RTCScene scene, RTCRay* ray, RTCOccludedArguments* arguments);
void __wrap_rtcOccluded1(RTCScene scene, RTCRay* ray, RTCOccludedArguments* arguments) {
  if (recording) recording->push_back({scene, *ray, true, false});
  __real_rtcOccluded1(scene, ray, arguments);
}
#else
void __real_rtcIntersect1(RTCScene scene, RTCIntersectContext* context, RTCRayHit* query);
void __wrap_rtcIntersect1(RTCScene scene, RTCIntersectContext* context, RTCRayHit* query) {
  if (recording)
    recording->push_back({scene, query->ray, false, context->flags == RTC_INTERSECT_CONTEXT_FLAG_COHERENT});
  __real_rtcIntersect1(scene, context, query);
}
void __real_rtcOccluded1(RTCScene scene, RTCIntersectContext* context, RTCRay* ray);
void __wrap_rtcOccluded1(RTCScene scene, RTCIntersectContext* context, RTCRay* ray) {
  if (recording) recording->push_back({scene, *ray, true, false});
  __real_rtcOccluded1(scene, context, ray);
}
#endif
}

namespace {

using namespace ajar;

constexpr size_t kChunk = 4096;  ///< rays of one task, which takes several milliseconds, as a tile

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::shared_ptr<const Scene> build(const SceneDescription& description) {
  Diagnostics diagnostics;
  return Scene::build(description, {}, diagnostics);
}

/// Renders `samples` per pixel. The seed is fixed, so that every call traces the same rays.
void render(const std::shared_ptr<const Scene>& scene, int samples) {
  const RenderSettings& settings = scene->settings();
  Film film(settings.region[0], settings.region[1], settings.region[2], settings.region[3], {"Combined"});
  const auto integrator = make_integrator("path");
  const std::atomic<bool> stop{false};
  integrator->prepare(scene, 1);
  integrator->run_iteration(film, samples, stop);
}

/// All queries of a render in the order of one thread, without those for lamps.
std::vector<Query> record(const std::shared_ptr<const Scene>& scene, int samples) {
  std::vector<Query> queries;
  recording = &queries;
  tbb::task_arena(1).execute([&] { render(scene, samples); });
  recording = nullptr;
  if (queries.empty()) return queries;
  const RTCScene surfaces = queries.front().scene;
  std::erase_if(queries, [&](const Query& query) { return query.scene != surfaces; });
  return queries;
}

/// Traces the queries. Returns the number of hits, so that the compiler cannot remove the loop.
size_t trace(const std::vector<Query>& queries, RTCScene scene) {
  std::atomic<size_t> hits{0};
  tbb::parallel_for(
      tbb::blocked_range<size_t>(0, queries.size(), kChunk),
      [&](const tbb::blocked_range<size_t>& range) {
        size_t found = 0;
        for (size_t i = range.begin(); i < range.end(); ++i) {
          const Query& query = queries[i];
          if (query.any_hit) {
            RTCRay ray = query.ray;
            embree::occluded(scene, ray);
            found += ray.tfar < 0.0f;
          } else {
            RTCRayHit ray_hit;
            ray_hit.ray = query.ray;
            ray_hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            ray_hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
            embree::intersect(scene, ray_hit, query.coherent);
            found += ray_hit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
          }
        }
        hits += found;
      },
      tbb::simple_partitioner());
  return hits;
}

nlohmann::json rates(std::vector<double> seconds, size_t rays) {
  std::sort(seconds.begin(), seconds.end());
  const auto rate = [&](double s) { return double(rays) / s; };
  return {
      {"median", rate(seconds[seconds.size() / 2])}, {"least", rate(seconds.back())}, {"most", rate(seconds.front())}};
}

double median_ratio(const std::vector<double>& numerator, const std::vector<double>& denominator) {
  std::vector<double> ratios(numerator.size());
  for (size_t i = 0; i < ratios.size(); ++i) ratios[i] = numerator[i] / denominator[i];
  std::sort(ratios.begin(), ratios.end());
  return ratios[ratios.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc % 2 == 1) {
    std::fprintf(stderr, "usage: bare_embree SCENE.ajar [--samples N] [--threads N] [--repeats N]\n");
    return 2;
  }
  int samples = 4, threads = 2, repeats = 5;
  for (int i = 2; i + 1 < argc; i += 2) {
    const std::string option = argv[i];
    int& value = option == "--samples" ? samples : option == "--threads" ? threads : repeats;
    value = std::max(1, std::atoi(argv[i + 1]));
  }
  try {
    const SceneDescription description = load_description(argv[1]);
    const auto scene = build(description);
    default_flags = true;
    const auto default_scene = build(description);
    default_flags = false;
    const std::vector<Query> queries = record(scene, samples);
    const std::vector<Query> one_sample = record(default_scene, 1);
    if (queries.empty()) throw SceneError("the scene traces no rays");
    const RTCScene robust = queries.front().scene, plain = one_sample.front().scene;

    std::vector<double> engine, bare, bare_default;
    size_t hits = 0, default_hits = 0;
    tbb::task_arena arena(threads);
    for (int i = 0; i < repeats; ++i) {
      engine.push_back(seconds_of([&] { arena.execute([&] { render(scene, samples); }); }));
      bare.push_back(seconds_of([&] { arena.execute([&] { hits = trace(queries, robust); }); }));
      bare_default.push_back(seconds_of([&] { arena.execute([&] { default_hits = trace(queries, plain); }); }));
    }
    size_t shadow = 0;
    for (const Query& query : queries) shadow += query.any_hit;
    const nlohmann::json result = {{"rays", queries.size()},
                                   {"shadow_rays", shadow},
                                   {"hits", hits},
                                   {"hits_with_default_flags", default_hits},
                                   {"threads", threads},
                                   {"repeats", repeats},
                                   {"samples", samples},
                                   {"path_tracer_rays_per_second", rates(engine, queries.size())},
                                   {"bare_rays_per_second", rates(bare, queries.size())},
                                   {"bare_default_flags_rays_per_second", rates(bare_default, queries.size())},
                                   {"share_of_bare", median_ratio(bare, engine)},
                                   {"share_of_bare_default_flags", median_ratio(bare_default, engine)}};
    std::printf("%s\n", result.dump(1).c_str());
    return 0;
  } catch (const std::exception& exception) {
    std::fprintf(stderr, "bare_embree: %s\n", exception.what());
    return 1;
  }
}
