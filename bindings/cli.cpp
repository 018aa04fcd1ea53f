// ajar-render SCENE.ajar OUTPUT.exr|png [--samples N] [--seconds S] [--seed N] [--threads N] [--stats FILE.json]
// Renders a saved SceneDescription without Blender, or merges checkpoints of one frame.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>

#include "description/archive.h"
#include "film/image_io.h"
#include "render/session.h"

namespace {

int usage() {
  std::cerr << "usage: ajar-render SCENE.ajar OUTPUT.exr|.png [--samples N] [--seconds S] [--error RELMSE] "
               "[--integrator NAME]\n"
               "                   [--direct NAME] [--direct-samples N] [--guiding off|on|auto] [--vertex-merging "
               "off|on] [--image NAME] [--photons N] [--photon-radius METRES] [--gather-rays N] [--seed N] [--threads "
               "N] [--memory-limit MIB] [--stats FILE.json]\n"
               "                   [--checkpoint FILE] [--resume FILE]\n"
               "       ajar-render --merge OUTPUT.exr|.png MERGED.checkpoint A.checkpoint B.checkpoint ...\n";
  return 2;
}

/// A non-negative number. Exits with a message if `text` is none.
double number(const char* option, const char* text) {
  char* end = nullptr;
  const double value = std::strtod(text, &end);
  if (end == text || *end != '\0' || !(value >= 0.0)) {
    std::cerr << "ajar-render: " << option << " needs a number that is not negative, not '" << text << "'\n";
    std::exit(2);
  }
  return value;
}

/// Merges renders of one frame from several machines.
int merge_files(int argc, char** argv) {
  if (argc < 6) return usage();
  ajar::Checkpoint all = ajar::load_checkpoint(argv[4]);
  for (int i = 5; i < argc; ++i) all = ajar::merge(all, ajar::load_checkpoint(argv[i]));
  ajar::save_checkpoint(all, argv[3]);
  const auto combined = all.passes.find("Combined");
  if (combined != all.passes.end())
    ajar::write_image(argv[2], {all.region[2] - all.region[0], all.region[3] - all.region[1], 4, combined->second});
  std::cout << all.samples << " samples per pixel of " << all.seeds.size() << " renders\n";
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return usage();
  try {
    if (std::strcmp(argv[1], "--merge") == 0) return merge_files(argc, argv);
    ajar::SceneDescription description = ajar::load_description(argv[1]);
    ajar::RenderSettings& settings = description.settings;
    std::string statistics_path, checkpoint_path, resume_path;
    for (int i = 3; i < argc; i += 2) {
      if (i + 1 >= argc) return usage();
      const std::string option = argv[i];
      const char* value = argv[i + 1];
      if (option == "--samples")
        settings.samples = int(number("--samples", value));
      else if (option == "--seconds")
        settings.seconds = number("--seconds", value), settings.samples = 0;
      else if (option == "--error")
        settings.target_error = number("--error", value), settings.samples = 0;
      else if (option == "--integrator")
        settings.integrator = value;
      else if (option == "--direct")
        settings.direct = value;
      else if (option == "--direct-samples")
        settings.direct_samples = int(number("--direct-samples", value));
      else if (option == "--guiding")
        settings.guiding = value;
      else if (option == "--vertex-merging")
        settings.vertex_merging = value;
      else if (option == "--image")
        settings.image = value;
      else if (option == "--photons")
        settings.photons = int(number("--photons", value));
      else if (option == "--photon-radius")
        settings.photon_radius = float(number("--photon-radius", value));
      else if (option == "--gather-rays")
        settings.gather_rays = int(number("--gather-rays", value));
      else if (option == "--seed")
        settings.seed = uint32_t(number("--seed", value));
      else if (option == "--threads")
        settings.threads = int(number("--threads", value));
      else if (option == "--memory-limit")
        settings.memory_limit = int(number("--memory-limit", value));
      else if (option == "--stats")
        statistics_path = value;
      else if (option == "--checkpoint")
        checkpoint_path = value;
      else if (option == "--resume")
        resume_path = value;
      else
        return usage();
    }
    const uint64_t scene = checkpoint_path.empty() && resume_path.empty() ? 0 : ajar::fingerprint(description);
    ajar::Session session;
    if (!resume_path.empty()) session.resume(ajar::load_checkpoint(resume_path), scene);
    session.start(std::move(description));
    while (!session.wait(0.25)) {
      const ajar::Progress progress = session.progress();
      std::fprintf(stderr, "\r%-40s %5.1f %%  %.0f samples", progress.step.c_str(), 100.0 * double(progress.fraction),
                   progress.samples);
    }
    std::fputc('\n', stderr);
    for (const ajar::Diagnostic& diagnostic : session.diagnostics())
      std::cerr << diagnostic.object << ": " << diagnostic.message << "\n";
    if (const std::string error = session.take_error(); !error.empty()) {
      std::cerr << "ajar-render: " << error << "\n";
      return 1;
    }
    if (auto checkpoint = checkpoint_path.empty() ? std::nullopt : session.checkpoint()) {
      checkpoint->scene = scene;
      ajar::save_checkpoint(*checkpoint, checkpoint_path);
    }
    ajar::write_image(argv[2], {session.width(), session.height(), 4, session.snapshot("Combined")});
    if (!statistics_path.empty()) std::ofstream(statistics_path) << session.statistics_json() << "\n";
    return 0;
  } catch (const std::exception& exception) {
    std::cerr << "ajar-render: " << exception.what() << "\n";
    return 1;
  }
}
