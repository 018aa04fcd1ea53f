// Session, its reports, and the lists of integrators, methods and passes.
#include <utility>

#include "arrays.h"
#include "bind.h"
#include "film/film.h"
#include "integrators/integrator.h"
#include "integrators/learned.h"
#include "render/session.h"
#include "transport/hints/hint_suggestions.h"

namespace ajar::python {
namespace {

/// Destroying a session waits for its threads. Python code can run meanwhile.
struct DeleteWithoutLock {
  void operator()(Session* session) const {
    py::gil_scoped_release release;
    delete session;
  }
};

int channels_of(const std::string& pass) {
  if (const int channels = channels_of_pass(pass)) return channels;
  std::string valid;
  for (const PassInfo& info : known_passes()) valid += (valid.empty() ? "" : ", ") + info.name;
  throw py::value_error("unknown pass \"" + pass + "\"; valid: " + valid);
}

/// Returns (positions, powers, stored).
py::tuple photons(const Session& session, uint64_t max_photons) {
  PhotonPoints points;
  {
    py::gil_scoped_release release;
    points = session.photons(max_photons);
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
  channels_of(pass);  // throws for an unknown name
  std::vector<float> values;
  PassSize size;
  {
    py::gil_scoped_release release;
    values = session.snapshot(pass, &size);
  }
  if (values.empty()) return py::none();
  return take_array(std::move(values), {size_t(size.height), size_t(size.width), size_t(size.channels)});
}

/// Moves the pixels.
py::object pixels_of(ViewPicture& picture) {
  return take_array(std::exchange(picture.rgba, {}), {size_t(picture.height), size_t(picture.width), 4});
}

void bind_progress(py::module_& module) {
  py::class_<Progress> progress(module, "Progress", "The progress of a render.");
  py::enum_<Progress::Phase>(progress, "Phase", "The state of a session.")
      .value("Idle", Progress::Phase::Idle, "Nothing was started.")
      .value("Building", Progress::Phase::Building, "The scene is being built.")
      .value("Rendering", Progress::Phase::Rendering, "The image is being rendered.")
      .value("Done", Progress::Phase::Done, "A stop condition was met.")
      .value("Cancelled", Progress::Phase::Cancelled, "`cancel` ended the render.")
      .value("Failed", Progress::Phase::Failed, "An error ended the render; `take_error` has its text.");
  progress.def_readonly("phase", &Progress::phase, "Progress.Phase. The state of the session.")
      .def_readonly("step", &Progress::step, "str. The present step of the session, for the artist.")
      .def_readonly("fraction", &Progress::fraction, "float, 0 to 1. The part of the render that is done.")
      .def_readonly("samples", &Progress::samples, "float, samples per pixel. The mean over the image.")
      .def_readonly("iteration", &Progress::iteration,
                    "int, >= 0. The number of iterations of this render. There is an image from 1 on.")
      .def_readonly("render", &Progress::render,
                    "int, >= 0. The number of the render, as `start`, `update` and `change_view` return it.")
      .def_readonly("build_seconds", &Progress::build_seconds, "float, seconds. The time that building the scene took.")
      .def_readonly("render_seconds", &Progress::render_seconds, "float, seconds. The time since rendering began.")
      .def_readonly("remaining_seconds", &Progress::remaining_seconds,
                    "float, seconds. An estimate of the time until the first stop condition of the settings. Negative "
                    "when it is not known.")
      .def_readonly(
          "estimated_relmse", &Progress::estimated_relmse,
          "float, relMSE. The estimated relative mean squared error of the image. Negative when it is not known.")
      .def_readonly("denoised_relmse", &Progress::denoised_relmse,
                    "float, relMSE. The estimated error of the denoised image, which ends a render with a noise target "
                    "and `settings.denoised`. Negative when it is not known.")
      .def_property_readonly("shown_relmse", &Progress::shown_relmse,
                             "float, relMSE. The estimated error of the image that the artist sees: `denoised_relmse` "
                             "or `estimated_relmse`. Negative when it is not known.")
      .def_readonly("estimated_perceptual_error", &Progress::estimated_perceptual_error,
                    "float, cd/m^2. The estimated mean of e^2 / tvi(L) over the pixels. Negative when it is not known.")
      .def("__repr__", [](const Progress& p) {
        return p.step + " " + std::to_string(int(100.0f * p.fraction)) + " %, " + std::to_string(p.samples) +
               " samples";
      });

  py::class_<ViewPicture>(module, "ViewPicture", "A picture for a 3D view, see Session.show_pictures.")
      .def_readonly("render", &ViewPicture::render,
                    "int, >= 1. The number of its render, as `update` and `change_view` return it.")
      .def_readonly("iteration", &ViewPicture::iteration, "int, >= 1. The number of the iteration of its render.")
      .def_readonly("samples", &ViewPicture::samples, "float, samples per pixel.")
      .def_readonly("divider", &ViewPicture::divider,
                    "int, >= 1. The pixels of the view for one pixel of the picture, along a side.")
      .def_readonly("coarse_light", &ViewPicture::coarse_light,
                    "bool. Whether its light has half its resolution; its surfaces have all of it.")
      .def_readonly("not_denoised", &ViewPicture::not_denoised,
                    "str. Why the picture is noisy: the denoiser is missing or has failed. Empty if it is denoised.")
      .def(
          "take_pixels", &pixels_of,
          "Return float32[height, width, 4], rows from the bottom up. To be called once: the picture gives them away.");
}

void bind_reports(py::module_& module) {
  py::class_<Diagnostic> diagnostic(module, "Diagnostic", "A message about a part of the scene.");
  py::enum_<Diagnostic::Severity>(diagnostic, "Severity", "How serious a message is.")
      .value("Info", Diagnostic::Severity::Info, "For information.")
      .value("Warning", Diagnostic::Severity::Warning, "Something is rendered differently or left out.")
      .value("Error", Diagnostic::Severity::Error, "The render fails.");
  diagnostic.def_readonly("severity", &Diagnostic::severity, "Diagnostic.Severity. How serious the message is.")
      .def_readonly("object", &Diagnostic::object,
                    "str. The name of the object, material or image that the message is about.")
      .def_readonly("message", &Diagnostic::message, "str. A sentence for the artist.");

  py::class_<HintReport> hint(module, "HintReport", "How a light hint was attached to the scene.");
  py::enum_<HintSegmentState>(hint, "Segment", "The state of a segment of a hint.")
      .value("Attached", HintSegmentState::Attached, "Its ray was aimed at a control point and hit a surface.")
      .value("Bounced", HintSegmentState::Bounced, "Its ray left a mirror or glass and hit a surface.")
      .value("Failed", HintSegmentState::Failed, "Its ray found no usable surface.");
  hint.def_readonly("name", &HintReport::name, "str. The name of the hint.")
      .def_readonly("attached", &HintReport::attached,
                    "bool. Whether the hint is attached to a light and to surfaces, so that it is used.")
      .def_readonly("reason", &HintReport::reason, "str. Why the hint is not attached. Empty when it is.")
      .def_readonly("positions", &HintReport::positions,
                    "list of tuples of 3 floats, metres in world space. The vertices that were found, the one on the "
                    "light first.")
      .def_readonly(
          "segments", &HintReport::segments,
          "list of HintReport.Segment. The state of each segment between the vertices. The last one can have failed.");
}

void bind_integrator_info(py::module_& module) {
  py::enum_<Bias>(module, "Bias", "The bias of an estimator.")
      .value("Unbiased", Bias::Unbiased, "The expected image is the correct one after any number of samples.")
      .value("Consistent", Bias::Consistent, "The bias vanishes as the number of samples grows.")
      .value("Biased", Bias::Biased, "A bias remains with any number of samples.");
  py::class_<IntegratorInfo>(module, "IntegratorInfo", "An entry of `integrator_list()`.")
      .def_readonly("name", &IntegratorInfo::name, "str. The value for `RenderSettings.integrator`.")
      .def_readonly("number", &IntegratorInfo::number,
                    "int. The number that stands for the integrator in files of Blender.")
      .def_readonly("label", &IntegratorInfo::label, "str. The name in the user interface.")
      .def_readonly("bias", &IntegratorInfo::bias, "Bias. The bias of the image.")
      .def_readonly("sentence", &IntegratorInfo::sentence, "str. One sentence for the artist.")
      .def_readonly("bakes", &IntegratorInfo::bakes, "bool. Whether it renders what CameraKind.Texels sees.")
      .def_readonly("can_merge", &IntegratorInfo::can_merge,
                    "bool. Whether `RenderSettings.vertex_merging` has an effect.")
      .def_readonly("follows_hints", &IntegratorInfo::follows_hints, "bool. Whether the integrator uses light hints.");
}

}  // namespace

void bind_session(py::module_& module) {
  bind_progress(module);
  bind_reports(module);
  bind_integrator_info(module);
  py::class_<Learned, std::shared_ptr<Learned>>(
      module, "Learned",
      "What a frame of an animation has learned, for the next frame. It guides samples and is not part of an image.")
      .def_readonly("integrator", &Learned::integrator, "str. The name of the integrator that learned.")
      .def_readonly("frames", &Learned::frames, "int, >= 1. The number of frames of the animation so far.");
  using Release = py::call_guard<py::gil_scoped_release>;
  py::class_<Session, std::unique_ptr<Session, DeleteWithoutLock>>(
      module, "Session",
      "A render in its own threads. The owner polls it. Methods that do not wait return at once. Deleting a session "
      "cancels its render and waits for its threads.")
      .def(py::init<>(), "Make a session that does nothing yet.")
      .def(
          "next_frame",
          [](Session& session, SceneDescription& description) {
            return session.next_frame(std::exchange(description, {}));
          },
          py::arg("description"), Release(),
          "Like start, but what the description shares with the scene before is kept: meshes from add_shared_mesh with "
          "their structures, images, materials, the table of the world. The description is empty afterwards.")
      .def(
          "start",
          [](Session& session, SceneDescription& description, bool keep) {
            return session.start(keep ? description : std::exchange(description, {}));
          },
          py::arg("description"), py::arg("keep") = false, Release(),
          "Build the scene, render it, and return the number of the render at once. Without `keep` the description is "
          "empty afterwards; with it the description is copied. Errors, for example an unknown integrator or a missing "
          "camera, end the render with Progress.Phase.Failed and are returned by take_error.")
      .def(
          "update",
          [](Session& session, SceneDescription& description) {
            return session.update(std::exchange(description, {}));
          },
          py::arg("description"), Release(),
          "Render an edited scene and return the number of the render at once. Meshes from add_shared_mesh and images "
          "that the previous scene contained are not built again. A render in progress ends. The description is empty "
          "afterwards. Errors are those of start.")
      .def("change_view", &Session::change_view, py::arg("camera"), py::arg("settings"), Release(),
           "Render the present scene with another camera and other settings, and return the number of the render at "
           "once. Nothing is built again. The settings of caustics keep their values. Without a scene the render "
           "fails, see take_error.")
      .def(
          "resume",
          [](Session& session, const std::string& path, uint64_t scene) {
            session.resume(load_checkpoint(path), scene);
          },
          py::arg("path"), py::arg("scene") = 0, Release(),
          "Continue from a checkpoint file. To be called before start. Its samples count towards "
          "`RenderSettings.samples`. scene: SceneDescription.fingerprint(), or 0 to skip the comparison of scenes. "
          "Raises SceneError, which names the file, when it cannot be read. The render fails, see take_error, when the "
          "checkpoint is of another scene or frame.")
      .def(
          "begin_with",
          [](Session& session, std::shared_ptr<Learned> learned) { session.begin_with(std::move(learned)); },
          py::arg("learned"), Release(),
          "Begin with what the previous frame of an animation has learned, or with nothing (None). To be called before "
          "start. The render plan in statistics_json states which parts are used.")
      .def(
          "learned", [](const Session& session) { return std::const_pointer_cast<Learned>(session.learned()); },
          Release(), "Return a Learned for the next frame, or None unless the render is done.")
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
          "Write everything rendered so far to a file and return True, or return False before the first iteration has "
          "ended. scene: SceneDescription.fingerprint(), or 0. Raises SceneError, which names the file, when it cannot "
          "be written.")
      .def("cancel", &Session::cancel, Release(),
           "End the render. Returns at once; wait returns True when the threads have stopped.")
      .def("pause", &Session::pause, py::arg("paused"), Release(),
           "Pause the render after the present iteration, or continue it. The first iteration is always rendered. A "
           "time limit does not count the pause.")
      .def("show_pictures", &Session::show_pictures, py::arg("shown"), Release(),
           "Let the following renders of update and change_view make denoised pictures for a view, or not. The first "
           "picture of a render is coarse, as fine as about a tenth of a second allows; the last ones have the size of "
           "the settings. The settings need not ask for guides. Without a denoiser the pictures are noisy, and a "
           "Diagnostic says so.")
      .def("take_picture", &Session::take_picture, Release(),
           "Return the newest ViewPicture of the render that was asked for last, or None if there is no new one. Each "
           "picture is returned once.")
      .def("is_paused", &Session::is_paused, "Return whether the session is paused.")
      .def("wait", &Session::wait, py::arg("seconds"), Release(),
           "Wait until the render is done, cancelled or failed, and return True, or return False after this number of "
           "seconds (float, >= 0).")
      .def("progress", &Session::progress, Release(), "Return the present Progress. It does not change afterwards.")
      .def("take_error", &Session::take_error, Release(),
           "Return the text of the error that ended the render and forget it. Empty when there is none.")
      .def("diagnostics", &Session::diagnostics, Release(),
           "Return a list of Diagnostic about the scene: what is approximated, repaired or left out.")
      .def("hint_reports", &Session::hint_reports, Release(),
           "Return a list of HintReport, one for each light hint. Empty before the scene is built.")
      .def("snapshot", &snapshot, py::arg("pass_name"),
           "Return a pass as float32[height, width, channels], rows from the bottom up, as it was after the last "
           "iteration, or None before the first. The number of channels is known_passes()[pass_name]; \"Halves\" and "
           "\"Direct Halves\" have as many for each technique that renders the image. While the session renders, a "
           "pass is kept from the first call on, so that the first call can return None. Raises ValueError, which "
           "lists the valid names, for an unknown pass.")
      .def("photons", &photons, py::arg("max_photons") = 50000,
           "Return (positions, powers, stored) of the last photon pass, for display: float32[n, 3] in metres, world "
           "space; float32[n, 3] in watts; and the number of photons that were stored. n is at most `max_photons`; the "
           "photons are spread evenly over space. n is 0 for integrators without photons, and while the session "
           "renders, before the first iteration that ends after the first call.")
      .def("error_over_time", &error_over_time,
           "Return the estimates of the error so far as float64[n, 4], the oldest first: seconds, samples per pixel, "
           "relative mean squared error, perceptual error.")
      .def_property_readonly("width", &Session::width,
                             "int, pixels. The width of the rendered region. 0 before the scene is built.")
      .def_property_readonly("height", &Session::height,
                             "int, pixels. The height of the rendered region. 0 before the scene is built.")
      .def("statistics_json", &Session::statistics_json, Release(),
           "Return the statistics of the render as JSON text: samples, seconds, rays, bytes, the render plan, the "
           "hints, the errors over time and the diagnostics. Names end in their unit.");

  module.def(
      "attach_hints",
      [](SceneDescription& description) {
        Diagnostics diagnostics;
        std::vector<HintReport> reports;
        Hints::attach(*Scene::build(std::exchange(description, {}), {}, diagnostics), reports);
        return reports;
      },
      py::arg("description"), Release(),
      "Build the scene, attach its light hints, and return a list of HintReport. The description is empty afterwards. "
      "Raises SceneError when the scene cannot be built.");
  module.def(
      "suggest_hints",
      [](SceneDescription& description, int count, int samples, uint32_t seed) {
        Diagnostics diagnostics;
        std::vector<std::pair<std::vector<Vec3>, double>> found;
        for (HintSuggestion& suggestion :
             suggest_hints(*Scene::build(std::exchange(description, {}), {}, diagnostics), count, samples, seed))
          found.emplace_back(std::move(suggestion.points), suggestion.share);
        return found;
      },
      py::arg("description"), py::arg("count") = 6, py::arg("samples") = 40000, py::arg("seed") = 0, Release(),
      "Return at most `count` suggestions for light hints as a list of (points, share), the most useful first: a list "
      "of tuples of 3 floats in metres, world space, and the part (0 to 1) of the error of path tracing that paths "
      "near this one cause. samples: the number of bidirectional samples of the pilot. The description is empty "
      "afterwards. Raises SceneError when the scene cannot be built.");
  module.def("integrator_list", &integrator_list, py::return_value_policy::reference,
             "Return the integrators as a list of IntegratorInfo, in the order of the user interface.");
  using Method = Choice<DirectMethod>;
  py::class_<Method>(module, "DirectMethodInfo", "An entry of `direct_method_list()`.")
      .def_readonly("name", &Method::name, "str. The value for `RenderSettings.direct`.")
      .def_readonly("label", &Method::label, "str. The name in the user interface.")
      .def_readonly("biased", &Method::biased, "bool. Whether the estimator is biased.")
      .def_readonly("sentence", &Method::sentence, "str. One sentence for the artist.");
  module.def(
      "direct_method_list",
      [] {
        const auto& all = choices<DirectMethod>().all;
        return std::vector<Method>(all.begin(), all.end());
      },
      "Return the estimators of direct light as a list of DirectMethodInfo, in the order of the user interface.");
  module.def(
      "known_passes",
      [] {
        py::dict passes;
        for (const PassInfo& info : known_passes()) passes[py::str(info.name)] = info.channels;
        return passes;
      },
      "Return a dict from the name of each pass with a fixed name to its number of channels. There are also "
      "CryptoObject00 to CryptoObject07 and the same for CryptoMaterial and CryptoAsset (4 channels: two ids with "
      "their coverages), \"AOV Color \" and \"AOV Value \" with the name of an AOV (4 and 1), and \"Combined_\" with "
      "the name of a light group (3).");
  module.def("name_hash", &murmur_hash3, py::arg("name"),
             "Return the hash of a name in Cryptomatte: MurmurHash3 with 32 bits.");
  module.def("matte_id", &matte_id, py::arg("name"), "Return the id of a name in the passes of Cryptomatte.");
}

}  // namespace ajar::python
