#include "server/threads/composition_turns.h"

#include <algorithm>
#include <utility>

#include "server/threads/limits.h"

namespace isthmus::server {

CompositionTurns::Turn CompositionTurns::Next(std::vector<PlacedSubmap> placed) {
  std::vector<std::pair<uint64_t, SubmapId>> news;  // By points.
  for (const PlacedSubmap& p : placed) {
    if (has_shown_ && p.submap != nullptr && !shown_.contains(p.submap->id)) {
      news.emplace_back(p.submap->point_count, p.submap->id);
    }
  }
  std::sort(news.begin(), news.end());
  uint64_t points = 0;
  const auto large = std::ranges::find_if(news, [&points](const auto& submap) {
    points += submap.first;
    return points > kTurnPoints;
  });
  Turn turn;
  turn.has_large = large != news.end() && (large == news.begin() || put_off_ == PutOff::kWaited);
  turn.gives_way = turn.has_large && put_off_ == PutOff::kNot;
  const std::map<SubmapId, uint64_t> before = std::exchange(waits_since_, {});
  ++turns_;
  for (auto it = large; it != news.end(); ++it) {
    const auto since = before.find(it->second);
    waits_since_[it->second] = since == before.end() ? turns_ : since->second;
  }
  std::stable_sort(large, news.end(), [this](const auto& a, const auto& b) {
    return waits_since_[a.second] < waits_since_[b.second];
  });
  std::set<SubmapId> waiting;
  for (auto it = large + (turn.has_large ? 1 : 0); it != news.end(); ++it) {
    waiting.insert(it->second);
  }
  std::erase_if(placed, [&waiting](const PlacedSubmap& p) {
    return p.submap != nullptr && waiting.contains(p.submap->id);
  });
  turn.placed = std::move(placed);
  turn.waiting = waiting.size();
  return turn;
}

void CompositionTurns::NoteShown(const Turn& turn) {
  has_shown_ = true;
  shown_.clear();
  for (const PlacedSubmap& p : turn.placed) {
    if (p.submap != nullptr) shown_.insert(p.submap->id);
  }
  put_off_ = turn.waiting > 0 && !turn.has_large ? PutOff::kWaited : PutOff::kNot;
}

}  // namespace isthmus::server
