// The composite of an image with shadow catchers, as in Cycles.
//
// A sample is caught if the camera sees a catcher before any other opaque surface. Its light is compared with the light
// that the catcher scatters in a scene without the other objects. The matte is the image of all other samples, in which
// caught samples are transparent. With the ratio r = (light of caught samples) / (the same without other objects) of a
// pixel and the alpha a of the matte, the composite is the matte, with the alpha a + (1 - a) (1 - mean of r, at most 1). Without a
// transparent film, it is over the background. The ratio of two means is consistent, not unbiased.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "math/types.h"

namespace ajar {

/// What a sample contributes to the composite.
struct CaughtSample {
  bool caught = false;
  Color lit{0.0f};         ///< light of a caught sample from the catcher
  Color alone{0.0f};       ///< the same without the other objects
  Color matte{0.0f};       ///< other light of the sample
  float alpha = 0.0f;      ///< of the matte
  Color background{0.0f};  ///< that would be seen without the catcher
};

class CaughtLight {
 public:
  bool enabled() const { return !sums_.empty(); }
  void enable(size_t pixel_count, bool transparent_film);
  /// `odd`: the half to which the sample belongs.
  void add(size_t pixel, const CaughtSample& sample, bool odd);
  /// The composite of a pixel: colour and alpha. `even`, `odd`: number of its samples in each half; 0 leaves a half out.
  void composite(size_t pixel, uint32_t even, uint32_t odd, double exposure, float out[4]) const;
  /// The ratio r.
  void shadow(size_t pixel, float out[3]) const;
  size_t memory_bytes() const { return sums_.size() * sizeof(Sums); }

 private:
  struct Sums {
    double lit[3] = {0, 0, 0}, alone[3] = {0, 0, 0}, matte[3] = {0, 0, 0}, background[3] = {0, 0, 0}, alpha = 0.0;
    bool caught = false;
    void add(const Sums& other);
    double ratio(int channel) const;
  };
  std::vector<Sums> sums_;  // of both halves of each pixel
  bool transparent_film_ = false;
};

}  // namespace ajar
