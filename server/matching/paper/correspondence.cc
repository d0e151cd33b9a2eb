#include "server/matching/paper/correspondence.h"

#include <algorithm>
#include <utility>

namespace isthmus::matching {
namespace {

// The k nearest of one descriptor, nearest first; insertion is quick for the small k used here.
class NearestList {
 public:
  explicit NearestList(size_t k) : k_(k) { nearest_.reserve(k + 1); }

  // Candidates must come in ascending order of index, so that ties go to the lower one.
  void Offer(float distance2, int index) {
    if (nearest_.size() == k_ && distance2 >= nearest_.back().first) return;
    const auto place = std::upper_bound(
        nearest_.begin(), nearest_.end(), distance2,
        [](float d, const std::pair<float, int>& entry) { return d < entry.first; });
    nearest_.insert(place, {distance2, index});
    if (nearest_.size() > k_) nearest_.pop_back();
  }
  const std::vector<std::pair<float, int>>& entries() const { return nearest_; }

 private:
  size_t k_;
  std::vector<std::pair<float, int>> nearest_;
};

}  // namespace

std::vector<FeatureMatch> MatchReciprocally(const std::vector<FpfhDescriptor>& a,
                                            const std::vector<FpfhDescriptor>& b,
                                            const CorrespondenceOptions& options) {
  if (options.nearest <= 0) return {};
  const size_t k = static_cast<size_t>(options.nearest);
  std::vector<NearestList> of_a(a.size(), NearestList(k)), of_b(b.size(), NearestList(k));
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i].isZero(0)) continue;
    for (size_t j = 0; j < b.size(); ++j) {
      if (b[j].isZero(0)) continue;
      const float distance2 = (a[i] - b[j]).squaredNorm();
      of_a[i].Offer(distance2, static_cast<int>(j));
      of_b[j].Offer(distance2, static_cast<int>(i));
    }
  }
  std::vector<FeatureMatch> matches;
  for (size_t i = 0; i < a.size(); ++i) {
    std::vector<int> partners;
    for (const auto& [distance2, j] : of_a[i].entries()) {
      const auto& back = of_b[j].entries();
      const bool returned = std::any_of(back.begin(), back.end(), [&](const auto& entry) {
        return entry.second == static_cast<int>(i);
      });
      if (returned) partners.push_back(j);
    }
    std::sort(partners.begin(), partners.end());
    for (int j : partners) matches.push_back({static_cast<int>(i), j});
  }
  return matches;
}

}  // namespace isthmus::matching
