// Tables of which pairs the place index puts first.
#pragma once

#include <cstddef>
#include <optional>
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
  // A server with all sessions searched the pair in full, accepted it, has both in one frame.
  bool is_searched = false, is_accepted = false, is_joined = false;
  bool is_found = false;  // By a search of this pair alone; of pairs that overlap.
};

// Share of the smaller map from which on maps overlap.
inline constexpr double kLeastOverlap = 0.15;

struct ServerSearches {
  size_t looks = 0, searches = 0;  // Pairs; those searched in full are among the former.
  double cpu_s = 0;                // Until there was nothing left to do.
};

// Numbers of partners that are tabulated.
inline constexpr size_t kPartnerCounts[] = {2, 4, 5, 6, 8, 12, 20};

struct IndexResults {
  size_t sessions = 0;
  std::vector<ComparedPair> pairs;
  std::vector<double> plan_ms, compare_ms;  // CPU time.
  size_t bytes = 0;                         // Sum over all plans.
  std::optional<ServerSearches> server = {};
};

// Markdown.
std::string PlaceIndexTable(const IndexResults& results);

}  // namespace isthmus::bench
