// The loop over samples of integrators with paths from the eye: tiles in parallel, and the samples of a pixel one after
// another.
//
// A pixel gets the number of samples of its goal (film/image_plan.h), or the same number as all pixels. The index of a
// sample is its number within its pixel, so images depend neither on the division of a render into iterations nor on
// the threads.
#pragma once

#include <algorithm>
#include <atomic>

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include "film/film.h"

namespace ajar {

/// Edge of a tile in pixels. One thread renders a tile.
constexpr int kTile = 16;

/// Calls `sample(tile_state, pixel x, pixel y, index)` for each sample that a pixel of the film needs to reach its
/// goal, or `uniform` where no goals are set. `begin_tile()` returns the state. Each sample must be added to the film.
/// Returns early when `stop` is set.
template <class BeginTile, class Sample>
void for_each_sample(const Film& film, uint32_t uniform, const std::atomic<bool>& stop, BeginTile&& begin_tile,
                     Sample&& sample) {
  tbb::parallel_for(
      tbb::blocked_range2d<int>(0, (film.height() + kTile - 1) / kTile, 1, 0, (film.width() + kTile - 1) / kTile, 1),
      [&](const tbb::blocked_range2d<int>& tile) {
        auto&& state = begin_tile();
        const int x1 = std::min(tile.cols().end() * kTile, film.width()),
                  y1 = std::min(tile.rows().end() * kTile, film.height());
        for (int y = tile.rows().begin() * kTile; y < y1; ++y) {
          for (int x = tile.cols().begin() * kTile; x < x1; ++x) {
            const int px = film.x0() + x, py = film.y0() + y;
            const uint32_t goal = film.goal_of(px, py, uniform);
            for (uint32_t index = film.samples_of(px, py); index < goal; ++index) {
              if (stop.load(std::memory_order_relaxed)) return;
              sample(state, px, py, index);
            }
          }
        }
      },
      tbb::simple_partitioner());
}

}  // namespace ajar
