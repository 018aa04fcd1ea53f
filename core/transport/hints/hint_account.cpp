#include "transport/hints/hint_account.h"

namespace ajar {

void HintAccount::add_proposals(const std::vector<HintCounts>& counts) {
  if (proposals_.size() < counts.size()) proposals_.resize(counts.size());
  for (size_t i = 0; i < counts.size(); ++i) {
    proposals_[i].proposed += counts[i].proposed;
    proposals_[i].accepted += counts[i].accepted;
  }
}

void HintAccount::add(const HintAccount& other) {
  if (of_hints_.size() < other.of_hints_.size()) of_hints_.resize(other.of_hints_.size());
  light_ += other.light_;
  for (size_t i = 0; i < other.of_hints_.size(); ++i) of_hints_[i] += other.of_hints_[i];
  add_proposals(other.proposals_);
}

std::vector<HintStatistics> HintAccount::statistics(const std::vector<HintReport>& reports, double per_weight,
                                                    double other_light) const {
  const double light = light_ * per_weight + other_light;
  std::vector<HintStatistics> all;
  size_t hint = 0;  // reports are in the order of the hints, with failed ones in between
  for (const HintReport& report : reports) {
    all.push_back({report});
    if (!report.attached) continue;
    if (hint < proposals_.size()) {
      all.back().proposed = proposals_[hint].proposed;
      all.back().accepted = proposals_[hint].accepted;
    }
    if (hint < of_hints_.size() && light > 0.0) all.back().energy_share = per_weight * of_hints_[hint] / light;
    ++hint;
  }
  return all;
}

}  // namespace ajar
