// The closed choices among the settings, and one table of names for each.
//
// The name of a value stands in files, on the command line and in Python; the number of a value stands in .blend files.
// Neither ever changes. The integrator is no closed choice: it is a name that find_integrator (integrators/integrator.h)
// looks up, because the integrators are listed in a folder that this one does not know.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "description/bump_terminator.h"
#include "description/diagnostics.h"

namespace ajar {

enum class FilterKind : uint8_t { Box, Gaussian, BlackmanHarris };

/// Estimators of direct light.
enum class DirectMethod : uint8_t {
  Mis,
  Bsdf,
  Light,
  Ris,
  Correlated,
  PmcHi,
  Ocv,
  OcvPaper,
  OcvProgressive,
  MisBalance,
  PmcHiPaper
};

/// Path guiding. Auto: guided where a measurement during the render shows that it reduces the noise.
enum class Guiding : uint8_t { Off, On, Auto };
/// Whether paths that no connection finds are merged with photons (transport/bidirectional/vertex_merging.h).
enum class Merging : uint8_t { Off, On };
/// How samples are distributed over the pixels: equally, or by adaptive sampling (film/image_plan.h).
enum class ImageSampling : uint8_t { Uniform, PmcIp };
/// The error that adaptive sampling reduces.
enum class ErrorMeasure : uint8_t { Relative, Perceptual };

template <class E>
struct Choice {
  E value;
  const char* name;
  const char* label;     ///< in the UI
  const char* sentence;  ///< for the artist
  bool biased = false;   ///< the image has a bias that does not vanish
};

template <class E>
struct Choices {
  const char* what;                ///< of what these are the choices
  std::span<const Choice<E>> all;  ///< in the order of the UI
};

/// The table of an enum.
template <class E>
const Choices<E>& choices();
template <>
const Choices<FilterKind>& choices();
template <>
const Choices<BumpTerminator>& choices();
template <>
const Choices<DirectMethod>& choices();
template <>
const Choices<Guiding>& choices();
template <>
const Choices<Merging>& choices();
template <>
const Choices<ImageSampling>& choices();
template <>
const Choices<ErrorMeasure>& choices();

/// Whether files and Python have the names of the values. These two enums are numbers in files and enums in Python.
template <class E>
inline constexpr bool kKnownByName = true;
template <>
inline constexpr bool kKnownByName<FilterKind> = false;
template <>
inline constexpr bool kKnownByName<BumpTerminator> = false;

template <class E>
const Choice<E>& choice_of(E value) {
  for (const Choice<E>& choice : choices<E>().all)
    if (choice.value == value) return choice;
  throw SceneError(std::string("Unknown ") + choices<E>().what + ".");
}

template <class E>
const char* name_of(E value) {
  return choice_of(value).name;
}

/// Throws SceneError with the valid names for an unknown name.
template <class E>
E choice_named(const std::string& name) {
  std::string names;
  for (const Choice<E>& choice : choices<E>().all) {
    if (choice.name == name) return choice.value;
    names += (names.empty() ? "" : ", ") + std::string(choice.name);
  }
  throw SceneError(std::string("Unknown ") + choices<E>().what + " '" + name + "'. Valid names: " + names + ".");
}

}  // namespace ajar
