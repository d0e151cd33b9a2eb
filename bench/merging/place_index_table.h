// Tables of which pairs the place index puts first.
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <vector>

namespace isthmus::bench {

struct ComparedPair {
  std::string kind;  // Empty: of different kinds.
  double overlap = 0;
  double place = 1;           // In the order of the index, [0, 1).
  std::set<size_t> partners;  // With so many for each session it is searched.
  int a = 0, b = 0;
};

// Numbers of partners that are tabulated.
inline constexpr size_t kPartnerCounts[] = {2, 4, 5, 6, 8, 12, 20};

struct IndexResults {
  size_t sessions = 0;
  std::vector<ComparedPair> pairs;
  std::vector<double> plan_ms, compare_ms;  // CPU time.
  size_t bytes = 0;                         // Of all plans.
};

// Markdown.
std::string PlaceIndexTable(const IndexResults& results);

}  // namespace isthmus::bench
