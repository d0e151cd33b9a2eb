#include "core/floors/joining.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "core/floors/clutter.h"
#include "core/floors/furniture.h"
#include "core/floors/hull.h"
#include "core/floors/limits.h"
#include "core/floors/necks.h"

namespace isthmus::floors {
namespace {

class Groups {
 public:
  Groups(const Mask& ground, const Basins& basins)
      : ground_(ground),
        basins_(basins),
        parents_(basins.peaks.size()),
        areas_(basins.peaks.size()),
        hulls_(HullsOf(ground, basins.labels, basins.peaks.size())) {
    std::iota(parents_.begin(), parents_.end(), 0);
    for (const int32_t label : basins.labels) {
      if (label >= 0) ++areas_[static_cast<size_t>(label)];
    }
  }

  size_t Root(int32_t label) {
    auto at = static_cast<size_t>(label);
    while (parents_[at] != at) at = parents_[at] = parents_[parents_[at]];
    return at;
  }
  int64_t Area(int32_t label) { return areas_[Root(label)]; }

  // The share of other groups in the hull of both.
  double Between(int32_t a, int32_t b) {
    return ShareOf(HullOfBoth(a, b), [&](const Cell& cell) {
      if (!ground_.Has(cell.x, cell.y)) return false;
      const int32_t label = basins_.labels[ground_.Index(cell.x, cell.y)];
      return label >= 0 && Root(label) != Root(a) && Root(label) != Root(b);
    });
  }

  void Join(int32_t a, int32_t b) {
    if (Root(a) == Root(b)) return;
    Hull hull = HullOfBoth(a, b);
    const size_t from = Root(b), to = Root(a);
    parents_[from] = to;
    areas_[to] += areas_[from];
    hulls_[to] = std::move(hull);
  }

 private:
  Hull HullOfBoth(int32_t a, int32_t b) {
    Hull both = hulls_[Root(a)];
    const Hull& other = hulls_[Root(b)];
    both.insert(both.end(), other.begin(), other.end());
    return HullOf(std::move(both));
  }

  const Mask& ground_;
  const Basins& basins_;
  std::vector<size_t> parents_;
  std::vector<int64_t> areas_;  // Cells.
  std::vector<Hull> hulls_;
};

// A join takes away what is between others: the pieces of a room that is full of tables take
// several rounds, the smallest first.
void JoinAcross(std::vector<Neck> necks, Groups* groups) {
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    std::erase_if(necks, [&](const Neck& n) { return groups->Root(n.a) == groups->Root(n.b); });
    std::stable_sort(necks.begin(), necks.end(), [&](const Neck& m, const Neck& n) {
      return std::min(groups->Area(m.a), groups->Area(m.b)) <
             std::min(groups->Area(n.a), groups->Area(n.b));
    });
    for (const Neck& neck : necks) {
      if (groups->Root(neck.a) == groups->Root(neck.b)) continue;
      if (groups->Between(neck.a, neck.b) <= kMostBetween) groups->Join(neck.a, neck.b);
    }
  }
}

// The widest neck of each decides.
void JoinSmall(std::vector<Neck> necks, double smallest, double leak, Groups* groups) {
  std::stable_sort(necks.begin(), necks.end(),
                   [](const Neck& m, const Neck& n) { return m.square > n.square; });
  for (const Neck& neck : necks) {
    if (neck.Width() <= leak) continue;
    const int64_t least = std::min(groups->Area(neck.a), groups->Area(neck.b));
    if (static_cast<double>(least) < smallest) groups->Join(neck.a, neck.b);
  }
}

void Renumber(const std::vector<int32_t>& squares, double smallest, Groups* groups,
              Basins* basins) {
  std::vector<int32_t> numbers(basins->peaks.size(), -1);
  std::vector<size_t> peaks;
  std::vector<int32_t> labels = basins->labels;
  for (size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] < 0) continue;
    const int32_t label = std::exchange(labels[i], -1);
    if (static_cast<double>(groups->Area(label)) < smallest) continue;
    int32_t& number = numbers[groups->Root(label)];
    if (number < 0) {
      number = static_cast<int32_t>(peaks.size());
      peaks.push_back(i);
    }
    labels[i] = number;
    size_t& peak = peaks[static_cast<size_t>(number)];
    if (squares[i] > squares[peak]) peak = i;
  }
  *basins = {std::move(labels), std::move(peaks)};
}

}  // namespace

void JoinBasins(const Mask& ground, const std::vector<int32_t>& squares, double resolution_m,
                Basins* basins) {
  const double smallest = kSmallestRoomM2 / (resolution_m * resolution_m);
  const std::vector<Neck> necks = FindNecks(ground, squares, basins->labels);
  Groups groups(ground, *basins);
  std::vector<Neck> soft;
  const Solids solids = SolidsOf(ground, resolution_m);
  std::copy_if(necks.begin(), necks.end(), std::back_inserter(soft), [&](const Neck& neck) {
    return IsBetweenFurniture(neck, ground, solids, resolution_m);
  });
  JoinAcross(std::move(soft), &groups);
  JoinSmall(necks, smallest, kWidestLeakM / resolution_m, &groups);
  Renumber(squares, smallest, &groups, basins);
}

}  // namespace isthmus::floors
