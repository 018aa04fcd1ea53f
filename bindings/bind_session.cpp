// Session, what it reports, and the lists of what this build can do.
#include <utility>

#include "arrays.h"
#include "bind.h"
#include "film/film.h"
#include "integrators/integrator.h"
#include "integrators/learned.h"
#include "render/session.h"
#include "transport/direct_light.h"
#include "transport/hint_suggestions.h"

namespace ajar::python {
namespace {

/// Destroying a session waits for its threads; Python may go on meanwhile.
struct DeleteWithoutLock {
  void operator()(Session* session) const {
    py::gil_scoped_release release;
    delete session;
  }
};

int channels_of(const std::string& pass) {
  std::string valid;
  for (const PassInfo& info : known_passes()) {
    if (info.name == pass) return info.channels;
    valid += (valid.empty() ? "" : ", ") + info.name;
  }
  throw py::value_error("unknown pass \"" + pass + "\"; valid: " + valid);
}

/// (positions, powers, stored)
py::tuple photons(const Session& session, uint64_t most) {
  PhotonPoints points;
  {
    py::gil_scoped_release release;
    points = session.photons(most);
  }
  return py::make_tuple(to_array<float>(points.positions, 3), to_array<float>(points.powers, 3), points.stored);
}

py::array_t<double> error_over_time(const Session& session) {
  std::vector<ErrorPoint> points;
  {
    py::gil_scoped_release release;
    points = session.error_over_time();
  }
  py::array_t<double> out({py::ssize_t(points.size()), py::ssize_t(4)});
  auto values = out.mutable_unchecked<2>();
  for (size_t i = 0; i < points.size(); ++i) {
    const ErrorPoint& p = points[i];
    const double row[] = {p.seconds, p.samples, p.relmse, p.perceptual};
    for (size_t k = 0; k < 4; ++k) values(py::ssize_t(i), py::ssize_t(k)) = row[k];
  }
  return out;
}

py::object snapshot(const Session& session, const std::string& pass) {
  const size_t channels = channels_of(pass);
  std::vector<float> values;
  {
    py::gil_scoped_release release;
    values = session.snapshot(pass);
  }
  if (values.empty()) return py::none();
  const size_t width = session.width();
  const size_t height = width ? values.size() / (width * channels) : 0;
  if (width * height * channels != values.size()) throw std::runtime_error("pass \"" + pass + "\" has the wrong size");
  return take_array(std::move(values), {height, width, channels});
}

void bind_reports(py::module_& module) {
  py::class_<Progress> progress(module, "Progress");
  py::enum_<Progress::Phase>(progress, "Phase")
      .value("Idle", Progress::Phase::Idle)
      .value("Building", Progress::Phase::Building)
      .value("Rendering", Progress::Phase::Rendering)
      .value("Done", Progress::Phase::Done)
      .value("Cancelled", Progress::Phase::Cancelled)
      .value("Failed", Progress::Phase::Failed);
  progress.def_readonly("phase", &Progress::phase)
      .def_readonly("step", &Progress::step)
      .def_readonly("fraction", &Progress::fraction)
      .def_readonly("samples", &Progress::samples)
      .def_readonly("iteration", &Progress::iteration)
      .def_readonly("render", &Progress::render)
      .def_readonly("build_seconds", &Progress::build_seconds)
      .def_readonly("render_seconds", &Progress::render_seconds)
      .def_readonly("remaining_seconds", &Progress::remaining_seconds, "Until the first of the ends that the settings name; below 0: not known")
      .def_readonly("estimated_relmse", &Progress::estimated_relmse)
      .def_readonly("estimated_perceptual_error", &Progress::estimated_perceptual_error)
      .def("__repr__", [](const Progress& p) {
        return p.step + " " + std::to_string(int(100.0f * p.fraction)) + " %, " + std::to_string(p.samples) + " samples";
      });

  py::class_<Diagnostic> diagnostic(module, "Diagnostic");
  py::enum_<Diagnostic::Severity>(diagnostic, "Severity")
      .value("Info", Diagnostic::Severity::Info)
      .value("Warning", Diagnostic::Severity::Warning)
      .value("Error", Diagnostic::Severity::Error);
  diagnostic.def_readonly("severity", &Diagnostic::severity)
      .def_readonly("object", &Diagnostic::object)
      .def_readonly("message", &Diagnostic::message);

  py::class_<HintReport> hint(module, "HintReport");
  py::enum_<HintSegmentState>(hint, "Segment")
      .value("Attached", HintSegmentState::Attached)
      .value("Bounced", HintSegmentState::Bounced)
      .value("Failed", HintSegmentState::Failed);
  hint.def_readonly("name", &HintReport::name)
      .def_readonly("attached", &HintReport::attached)
      .def_readonly("reason", &HintReport::reason)
      .def_readonly("positions", &HintReport::positions)
      .def_readonly("segments", &HintReport::segments);

  py::enum_<Honesty>(module, "Honesty")
      .value("Unbiased", Honesty::Unbiased)
      .value("Consistent", Honesty::Consistent)
      .value("Biased", Honesty::Biased);
  py::class_<IntegratorInfo>(module, "IntegratorInfo")
      .def_readonly("name", &IntegratorInfo::name)
      .def_readonly("label", &IntegratorInfo::label)
      .def_readonly("honesty", &IntegratorInfo::honesty)
      .def_readonly("sentence", &IntegratorInfo::sentence)
      .def_readonly("can_merge", &IntegratorInfo::can_merge)
      .def_readonly("follows_hints", &IntegratorInfo::follows_hints);
}

}  // namespace

void bind_session(py::module_& module) {
  bind_reports(module);
  py::class_<Learned, std::shared_ptr<Learned>>(module, "Learned", "What a frame of an animation has learned, for the one after it.")
      .def_readonly("integrator", &Learned::integrator)
      .def_readonly("frames", &Learned::frames);
  using Release = py::call_guard<py::gil_scoped_release>;
  py::class_<Session, std::unique_ptr<Session, DeleteWithoutLock>>(module, "Session", "One render in its own threads; poll it.")
      .def(py::init<>())
      .def(
          "start",
          [](Session& session, SceneDescription& description, bool keep) {
            return session.start(keep ? description : std::exchange(description, {}));
          },
          py::arg("description"), py::arg("keep") = false, Release(),
          "Build and render. Returns at once. Unless `keep`, the description is emptied (it is not copied).")
      .def(
          "update", [](Session& session, SceneDescription& description) { return session.update(std::exchange(description, {})); },
          py::arg("description"), Release(),
          "Render the scene as it is now, and keep what it shares with the one before. Empties the description; returns at once, with the "
          "number that Progress.render will show.")
      .def("change_view", &Session::change_view, py::arg("camera"), py::arg("settings"), Release(),
           "Render the scene at hand from another camera. Returns like update.")
      .def(
          "resume", [](Session& session, const std::string& path, uint64_t scene) { session.resume(load_checkpoint(path), scene); }, py::arg("path"),
          py::arg("scene") = 0, Release(),
          "Before start: go on from a checkpoint file. Its samples count towards those asked for. One of another scene is refused, if `scene` is "
          "SceneDescription.fingerprint().")
      .def(
          "begin_with", [](Session& session, std::shared_ptr<Learned> learned) { session.begin_with(std::move(learned)); }, py::arg("learned"), Release(),
          "Before start: begin with what the frame before has learned, or with nothing (None). The plan says what is used.")
      .def("learned", [](const Session& session) { return std::const_pointer_cast<Learned>(session.learned()); }, Release(),
           "What the next frame may begin with; None unless the render is done.")
      .def(
          "save_checkpoint",
          [](const Session& session, const std::string& path, uint64_t scene) {
            auto checkpoint = session.checkpoint();
            if (!checkpoint) return false;
            checkpoint->scene = scene;
            save_checkpoint(*checkpoint, path);
            return true;
          },
          py::arg("path"), py::arg("scene") = 0, Release(),
          "Write everything found so far; `scene` is SceneDescription.fingerprint(). False before the first iteration has ended.")
      .def("cancel", &Session::cancel, Release())
      .def("pause", &Session::pause, py::arg("paused"), Release(), "Let the render wait after the iteration it is in, or go on. A time limit does not count the wait.")
      .def("is_paused", &Session::is_paused)
      .def("wait", &Session::wait, py::arg("seconds"), Release(), "True when done, cancelled or failed.")
      .def("progress", &Session::progress, Release())
      .def("take_error", &Session::take_error, Release(), "What went wrong, once; empty when nothing has.")
      .def("diagnostics", &Session::diagnostics, Release())
      .def("hint_reports", &Session::hint_reports, Release(), "How the artist's light paths were attached.")
      .def("snapshot", &snapshot, py::arg("pass_name"), "float32[height, width, channels], rows bottom up; None before the first.")
      .def("photons", &photons, py::arg("most") = 50000,
           "Photons of the last pass, for people to look at: float32[n, 3] positions in world space, float32[n, 3] powers in watts, and how many were "
           "stored, of which at most `most` come, spread evenly over space. Empty from integrators without photons, and while rendering before the first "
           "iteration that ends after one was asked.")
      .def("error_over_time", &error_over_time, "float64[n, 4]: seconds, samples per pixel, relative mean squared error, perceptual error; the oldest first.")
      .def_property_readonly("width", &Session::width)
      .def_property_readonly("height", &Session::height)
      .def("statistics_json", &Session::statistics_json, Release());

  module.def(
      "attach_hints",
      [](SceneDescription& description) {
        Diagnostics diagnostics;
        std::vector<HintReport> reports;
        Hints::attach(*Scene::build(std::exchange(description, {}), {}, diagnostics), reports);
        return reports;
      },
      py::arg("description"), Release(), "Build the scene and attach its light paths. Empties the description.");
  module.def(
      "suggest_hints",
      [](SceneDescription& description, int count, int samples, uint32_t seed) {
        Diagnostics diagnostics;
        std::vector<std::pair<std::vector<Vec3>, double>> found;
        for (HintSuggestion& suggestion : suggest_hints(*Scene::build(std::exchange(description, {}), {}, diagnostics), count, samples, seed))
          found.emplace_back(std::move(suggestion.points), suggestion.share);
        return found;
      },
      py::arg("description"), py::arg("count") = 6, py::arg("samples") = 40000, py::arg("seed") = 0, Release(),
      "Light paths that path tracing finds too seldom: (points, share of the difficulty), the most useful first. Empties the description.");
  module.def("integrator_list", &integrator_list, py::return_value_policy::reference);
  py::class_<DirectMethodInfo>(module, "DirectMethodInfo")
      .def_readonly("name", &DirectMethodInfo::name)
      .def_readonly("label", &DirectMethodInfo::label)
      .def_readonly("biased", &DirectMethodInfo::biased)
      .def_readonly("sentence", &DirectMethodInfo::sentence);
  module.def("direct_method_list", &direct_method_list, py::return_value_policy::reference);
  module.def("known_passes", [] {
    py::dict passes;
    for (const PassInfo& info : known_passes()) passes[py::str(info.name)] = info.channels;
    return passes;
  }, "Channels of each pass, by name.");
}

}  // namespace ajar::python
