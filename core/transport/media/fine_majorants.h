// Majorants of small cells inside the cells of a grid of majorants.
//
// Where the extinction changes by powers of ten within a cell, such as in the atmosphere of a planet, one majorant for
// the whole cell makes nearly all collisions null. Such cells are divided. The majorants of the small cells are found
// when a ray first enters the cell, because many cells are never entered: those inside the planet, or behind it. They do
// not depend on the ray that enters first.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace ajar {

class FineMajorants {
 public:
  static constexpr int kAlong = 8;             ///< small cells along each axis of a cell
  static constexpr size_t kMaxDivided = 2048;  ///< of all media together
  /// Codes of the majorants, x varies fastest. A byte for each keeps the memory small.
  using Cells = std::array<uint8_t, size_t(kAlong) * kAlong * kAlong>;

  FineMajorants() = default;
  /// `cells`: of the grid. `divided`: indices of those that are divided; at most kMaxDivided.
  FineMajorants(size_t cells, const std::vector<size_t>& divided) {
    if (divided.empty()) return;
    block_of_.resize(cells, 0);
    blocks_ = std::make_unique<Block[]>(divided.size());
    for (size_t i = 0; i < divided.size(); ++i) block_of_[divided[i]] = uint16_t(i + 1);
    count_ = divided.size();
  }
  /// The code of a share of the majorant of the whole cell, in (0, 1]: eighths of octaves below 1, so that the share of the
  /// code is at least this one and at most 9 % more, down to 2^-31.
  static uint8_t code_of(float share) { return uint8_t(std::clamp(-8.0f * std::log2(share) - 1e-3f, 0.0f, 255.0f)); }
  static float share_of(uint8_t code) { return std::exp2(-0.125f * float(code)); }
  bool divides(size_t cell) const { return count_ > 0 && block_of_[cell] != 0; }
  /// The majorants in a cell that is divided. `find(Cells&)` is called once for each cell.
  template <class Find>
  const Cells& in(size_t cell, const Find& find) const {
    Block& block = blocks_[size_t(block_of_[cell]) - 1];
    std::call_once(block.found, [&] { find(block.cells); });
    return block.cells;
  }
  size_t memory_bytes() const { return bytes_of(count_, block_of_.capacity()); }
  static constexpr size_t bytes_of(size_t divided, size_t cells) {
    return divided * sizeof(Block) + cells * sizeof(uint16_t);
  }

 private:
  struct Block {
    std::once_flag found;
    Cells cells;
  };
  std::vector<uint16_t> block_of_;  ///< of each cell: its block plus 1; 0: it is not divided
  std::unique_ptr<Block[]> blocks_;
  size_t count_ = 0;
};

}  // namespace ajar
