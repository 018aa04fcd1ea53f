// ajar-render SCENE.ajar OUTPUT.exr|png [options]
// Renders a saved SceneDescription without Blender, or merges checkpoints of one frame. Each setting is an
// option (settings_table.h) and overrides that of the file.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <functional>
#include <iostream>
#include <optional>
#include <sstream>

#include "description/archive.h"
#include "description/settings_table.h"
#include "film/image_io.h"
#include "platform/platform.h"
#include "render/session.h"

namespace {

using namespace ajar;

constexpr int kUsageError = 2;

/// What the options change, in their order on the command line.
using Changes = std::vector<std::function<void(RenderSettings&)>>;

std::string option_name(const std::string& prefix, const char* name) {
  std::string text = prefix + name;
  std::replace(text.begin(), text.end(), '_', '-');
  return text;
}

/// Refuse a number outside the range. The help shows bounds that are no limits of the type.
template <class T>
void check_range(CLI::Option* option, const SettingRange& range) {
  if (range.min <= -kMaxFloat) return;
  const bool has_max = range.max < kMaxFloat;
  std::ostringstream shown;
  if (!has_max) shown << ">= " << range.min;
  option->check(CLI::Range(T(range.min), has_max ? T(range.max) : std::numeric_limits<T>::max(), shown.str()));
}

template <class E>
std::vector<std::string> names_of() {
  std::vector<std::string> names;
  for (const Choice<E>& choice : choices<E>().all) names.emplace_back(choice.name);
  return names;
}

/// An option whose value `set` takes, after those before it on the command line.
template <class Value>
CLI::Option* add_option(CLI::App& app, const std::string& name, const std::string& text, Changes& changes,
                        std::function<void(RenderSettings&, const Value&)> set) {
  const auto note = [&changes, set](const Value& value) {
    changes.emplace_back([set, value](RenderSettings& settings) { set(settings, value); });
  };
  return app.add_option_function<Value>("--" + name, note, text)->trigger_on_parse()->take_last();
}

/// Options for the rows of a struct that is in the settings at `of`.
template <class Struct>
void add_options(CLI::App& app, Changes& changes, const std::string& prefix,
                 std::function<Struct&(RenderSettings&)> of) {
  Struct defaults;
  for (const Setting<Struct>& row : setting_table<Struct>()) {
    const std::string name = row.option ? row.option : option_name(prefix, row.name);
    const std::string text = row.text + (*row.unit ? std::string(" Unit: ") + row.unit + "." : "");
    const auto add = [&]<class T>(T*) {
      const auto set = [&row, of](RenderSettings& settings, const T& value) {
        const SettingField field = row.field(of(settings));
        *std::get<T*>(field) = value;
        // Another end of the render replaces the number of samples.
        if (field == SettingField(&settings.seconds) || field == SettingField(&settings.target_error))
          settings.samples = 0;
      };
      if constexpr (std::is_same_v<T, BounceLimits>) {
        add_options<BounceLimits>(app, changes, name + "-",
                                  [](RenderSettings& settings) -> BounceLimits& { return settings.bounces; });
      } else if constexpr (std::is_same_v<T, MistDescription>) {
        add_option<std::vector<float>>(app, name, text, changes,
                                       [set](RenderSettings& settings, const std::vector<float>& v) {
                                         set(settings, {v[0], v[1], v[2]});
                                       })
            ->expected(3);
      } else if constexpr (std::is_same_v<T, std::array<int, 4>> || std::is_same_v<T, std::array<float, 4>>) {
        using Values = std::vector<typename T::value_type>;
        add_option<Values>(app, name, text, changes, [set](RenderSettings& settings, const Values& v) {
          set(settings, {v[0], v[1], v[2], v[3]});
        })->expected(4);
      } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
        add_option<T>(app, name, text, changes, set)->delimiter(',')->expected(1)->type_name("NAME,...");
      } else if constexpr (std::is_same_v<T, bool>) {
        add_option<std::string>(app, name, text, changes, [set](RenderSettings& settings, const std::string& text) {
          set(settings, text == "on");
        })->check(CLI::IsMember({"on", "off"}));
      } else if constexpr (std::is_enum_v<T>) {
        add_option<std::string>(app, name, text, changes, [set](RenderSettings& settings, const std::string& text) {
          set(settings, choice_named<T>(text));
        })->check(CLI::IsMember(names_of<T>()));
      } else if constexpr (std::is_same_v<T, std::string>) {
        add_option<T>(app, name, text, changes, set)->type_name("NAME");
      } else {
        check_range<T>(add_option<T>(app, name, text, changes, set), row.range);
      }
    };
    std::visit(add, row.field(defaults));
  }
}

struct Files {
  std::string scene, output, statistics, checkpoint, resume, continued;
  double interval = 30.0;
  std::optional<uint32_t> first_sample;
  bool keep_going = false, identity = false;
};

/// Merges renders of one frame from several machines, one after another: OUTPUT, MERGED, and the checkpoints.
int merge_files(const std::vector<std::string>& paths, bool keep_going) {
  CheckpointMerger merger;
  size_t left_out = 0;
  for (size_t i = 2; i < paths.size(); ++i) try {
      merger.add(load_checkpoint(paths[i]));
    } catch (const SceneError& error) {
      if (!keep_going) throw SceneError(paths[i] + ": " + error.what());
      ++left_out;
      std::cerr << "left out: " << paths[i] << ": " << error.what() << "\n";
    }
  if (merger.empty()) throw SceneError("There is no checkpoint to merge.");
  const std::string why_not_exact = merger.why_not_exact();
  const Checkpoint all = merger.finish();
  save_checkpoint(all, paths[1]);
  const auto combined = all.passes.find("Combined");
  if (combined != all.passes.end())
    write_image(paths[0], {all.region[2] - all.region[0], all.region[3] - all.region[1], 4, combined->second});
  const size_t renders = paths.size() - 2 - left_out;
  std::cout << all.samples << " samples per pixel of " << renders << (renders == 1 ? " render\n" : " renders\n");
  if (left_out > 0) std::cout << left_out << " left out\n";
  if (all.ranges.empty() || why_not_exact.empty()) return 0;
  std::cout << "merged by means: " << why_not_exact << "\n";
  return 0;
}

/// Set by the signals by which systems and schedulers end a process before they kill it.
volatile std::sig_atomic_t ended_by = 0;

/// The checkpoint to continue from; none: the render starts from its beginning. A damaged one is moved away.
std::optional<Checkpoint> checkpoint_to_continue(const Files& files) {
  if (!files.resume.empty()) return load_checkpoint(files.resume);
  std::error_code ignored;
  if (files.continued.empty() || !std::filesystem::exists(platform::file_path(files.continued), ignored))
    return std::nullopt;
  try {
    return load_checkpoint(files.continued);
  } catch (const SceneError& error) {
    std::cerr << error.what() << " It is moved to " << files.continued << ".damaged; the render starts again.\n";
    std::filesystem::rename(platform::file_path(files.continued), platform::file_path(files.continued + ".damaged"));
    return std::nullopt;
  }
}

/// Returns false, with a message, if it cannot be written. The file that was there remains.
bool write_checkpoint(const Session& session, uint64_t scene, const std::string& path) {
  auto checkpoint = session.checkpoint();
  if (!checkpoint) return true;
  checkpoint->scene = scene;
  try {
    save_checkpoint(*checkpoint, path);
  } catch (const SceneError& error) {
    std::cerr << "\najar-render: " << error.what() << "\n";
    return false;
  }
  return true;
}

/// Waits until the render is done, cancelled or failed, and writes checkpoints.
void follow(Session& session, const Files& files, uint64_t scene) {
  using Clock = std::chrono::steady_clock;
  auto next = Clock::now() + std::chrono::duration<double>(files.interval);
  while (!session.wait(0.25)) {
    if (ended_by != 0) session.cancel();
    const Progress progress = session.progress();
    std::fprintf(stderr, "\r%-40s %5.1f %%  %.0f samples", progress.step.c_str(), 100.0 * double(progress.fraction),
                 progress.samples);
    if (files.checkpoint.empty() || Clock::now() < next) continue;
    write_checkpoint(session, scene, files.checkpoint);
    next = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(files.interval));
  }
  std::fputc('\n', stderr);
}

/// The exit code.
int render(const Files& files, const Changes& changes) {
  SceneDescription description = load_description(files.scene);
  description.settings.texture_cache_generate = false;  // a scene from a stranger does not decide what is written
  for (const auto& change : changes) change(description.settings);
  if (files.identity) {
    std::cout << "{\"version\": \"" << AJAR_VERSION << "\", \"scene\": " << fingerprint(description)
              << ", \"view\": " << view_fingerprint(description.camera, description.settings) << "}\n";
    return 0;
  }
  const uint64_t scene = files.checkpoint.empty() && files.resume.empty() ? 0 : fingerprint(description);
  Session session;
  if (auto from = checkpoint_to_continue(files)) session.resume(std::move(*from), scene);
  if (files.first_sample) session.begin_at(*files.first_sample);
  if (!files.checkpoint.empty())
    for (const int signal : {SIGTERM, SIGINT}) std::signal(signal, [](int number) { ended_by = number; });
  if (!files.checkpoint.empty()) session.checkpoint();  // from now on, the session keeps one
  session.start(std::move(description));
  follow(session, files, scene);
  for (const Diagnostic& diagnostic : session.diagnostics())
    std::cerr << diagnostic.object << ": " << diagnostic.message << "\n";
  if (const std::string error = session.take_error(); !error.empty()) {
    std::cerr << "ajar-render: " << error << "\n";
    return 1;
  }
  if (!files.checkpoint.empty() && !write_checkpoint(session, scene, files.checkpoint)) return 1;
  if (ended_by != 0) return 128 + ended_by;
  write_image(files.output, {session.width(), session.height(), 4, session.snapshot("Combined")});
  if (!files.statistics.empty())
    std::ofstream(platform::file_path(files.statistics)) << session.statistics_json() << "\n";
  return 0;
}

int run(const std::vector<std::string>& arguments) {
  CLI::App app("Renders a scene that was saved as a description. Options override the settings of the file.",
               "ajar-render");
  app.allow_windows_style_options(false);  // a path may begin with a slash
  Files files;
  std::vector<std::string> paths;
  bool merges = false;
  app.add_option("files", paths, "SCENE.ajar OUTPUT.exr|.png, or with --merge: OUTPUT.exr|.png MERGED A B ...")
      ->required();
  app.add_flag("--merge", merges, "Merge the checkpoints A, B, ... of one frame into the checkpoint MERGED");
  app.add_flag("--keep-going", files.keep_going,
               "With --merge: leave out checkpoints that are damaged or do not fit, and say so");
  app.add_flag("--identity", files.identity,
               "Render nothing: print what checkpoints of this scene with these settings have in common, as JSON");
  app.add_option("--stats", files.statistics, "Write the statistics of the render to this file, as JSON");
  auto* checkpoint = app.add_option("--checkpoint", files.checkpoint,
                                    "Write a checkpoint to this file from time to time, at the end, and when the "
                                    "render is terminated (SIGTERM, SIGINT)");
  app.add_option("--checkpoint-interval", files.interval, "Seconds between two checkpoints")
      ->check(CLI::Range(0.0, 1e6));
  auto* resume = app.add_option("--resume", files.resume, "Continue from this checkpoint");
  app.add_option("--continue", files.continued,
                 "Both --checkpoint and, if the file exists and is whole, --resume; a damaged one is moved away")
      ->excludes(checkpoint, resume);
  app.add_option("--first-sample", files.first_sample,
                 "The number of the first sample of each pixel. Renders of other ranges with the same seed are merged "
                 "to the image of one render, bit for bit. Where samples depend on each other, the number gives the "
                 "render a seed of its own instead");
  Changes changes;
  add_options<RenderSettings>(app, changes, "", [](RenderSettings& settings) -> RenderSettings& { return settings; });
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));  // CLI11 takes them from the end
    if (merges ? paths.size() < 3 : paths.size() != 2)
      throw CLI::ValidationError("files", merges ? "--merge needs OUTPUT, MERGED and checkpoints"
                                                 : "a scene and an output are needed, and nothing else");
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageError;
  }
  if (merges) return merge_files(paths, files.keep_going);
  if (!files.continued.empty()) files.checkpoint = files.continued;
  files.scene = paths[0];
  files.output = paths[1];
  return render(files, changes);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(ajar::platform::arguments(argc, argv));
  } catch (const std::exception& exception) {
    std::cerr << "ajar-render: " << exception.what() << "\n";
    return 1;
  }
}
