#include "lab/bench/merging/place_index_table.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <set>

#include "lab/bench/merging/figures.h"
#include "server/matching/index/limits.h"

namespace isthmus::bench {
namespace {

using IsSearched = std::function<bool(const ComparedPair&)>;

// The share that is searched of the pairs that overlap by so much.
double Recall(const IndexResults& results, double least, const IsSearched& is_searched,
              const std::string& kind = "") {
  int count = 0, found = 0;
  for (const ComparedPair& pair : results.pairs) {
    if (pair.overlap < least || (!kind.empty() && pair.kind != kind)) continue;
    ++count;
    found += is_searched(pair);
  }
  return count == 0 ? 1 : static_cast<double>(found) / count;
}

// If every search of two sessions that overlap by 0.3 finds it: the share of the pairs that do
// which are in one component.
double Joined(const IndexResults& results, const IsSearched& is_searched) {
  std::vector<int> parent(results.sessions);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const ComparedPair& pair : results.pairs) {
    if (pair.overlap >= 0.3 && is_searched(pair)) parent[root(pair.a)] = root(pair.b);
  }
  return Recall(results, 0.3,
                [&](const ComparedPair& pair) { return root(pair.a) == root(pair.b); });
}

std::set<std::string> KindsOf(const IndexResults& results, double least) {
  std::set<std::string> kinds;
  for (const ComparedPair& pair : results.pairs) {
    if (!pair.kind.empty() && pair.overlap >= least) kinds.insert(pair.kind);
  }
  return kinds;
}

std::string Row(const IndexResults& results, const std::string& name,
                const IsSearched& is_searched) {
  const auto searched = std::count_if(results.pairs.begin(), results.pairs.end(), is_searched);
  std::vector<double> by_kind;
  for (const std::string& kind : KindsOf(results, 0.3)) {
    by_kind.push_back(Recall(results, 0.3, is_searched, kind));
  }
  std::sort(by_kind.begin(), by_kind.end());
  if (by_kind.empty()) by_kind.push_back(1);
  return absl::StrFormat(
      "| %s | %.1f %% | %.0f %% | %.0f %% | %.0f %% (%.0f %%) | %.0f %% |\n", name,
      100.0 * static_cast<double>(searched) / static_cast<double>(results.pairs.size()),
      100 * Recall(results, 0.15, is_searched), 100 * Recall(results, 0.3, is_searched),
      100 * by_kind[by_kind.size() / 2], 100 * by_kind.front(), 100 * Joined(results, is_searched));
}

// From 0.15 and from 0.3 on.
std::string Recalls(const IndexResults& results, const std::string& kind,
                    const IsSearched& is_searched) {
  return absl::StrFormat(" | %.0f %%, %.0f %%", 100 * Recall(results, 0.15, is_searched, kind),
                         100 * Recall(results, 0.3, is_searched, kind));
}

std::string KindTable(const IndexResults& results) {
  std::string table =
      absl::StrCat("| kind | 5 %: from 0.15, 0.3 on | 10 % | 20 % | ", matching::kSearchPartners,
                   " partners |\n|---|---|---|---|---|\n");
  for (const std::string& kind : KindsOf(results, 0.15)) {
    absl::StrAppend(&table, "| ", kind);
    for (const double share : {0.05, 0.1, 0.2}) {
      table += Recalls(results, kind, [&](const auto& pair) { return pair.place < share; });
    }
    table += Recalls(results, kind, [](const auto& pair) {
      return pair.partners.contains(matching::kSearchPartners);
    });
    table += " |\n";
  }
  return table;
}

// The shares that the server searched, accepted and has in one frame: of the pairs that overlap by
// so much, and of the ones among them that are found when searched.
std::string ServerTable(const IndexResults& results) {
  const size_t all = results.sessions * (results.sessions - 1) / 2;
  const auto share = [all](size_t pairs) {
    return 100.0 * static_cast<double>(pairs) / static_cast<double>(all);
  };
  std::string table = absl::StrFormat(
      "\nA server with all of them: %d pairs looked at, %.1f %% of all, of which %d were searched "
      "in "
      "full, %.1f %% of all; %.0f s of CPU time.\n\n"
      "| pairs | how many | searched in full | accepted | in one frame |\n|---|---|---|---|---|\n",
      results.server->looks, share(results.server->looks), results.server->searches,
      share(results.server->searches), results.server->cpu_s);
  for (const bool found : {false, true}) {
    for (const double least : {kLeastOverlap, 0.3}) {
      int count = 0, searched = 0, accepted = 0, joined = 0;
      for (const ComparedPair& pair : results.pairs) {
        if (pair.overlap < least || (found && !pair.is_found)) continue;
        ++count;
        searched += pair.is_searched;
        accepted += pair.is_accepted;
        joined += pair.is_joined;
      }
      const auto percent = [&](int n) { return count == 0 ? 0 : 100.0 * n / count; };
      absl::StrAppendFormat(&table, "| %.2f and more%s | %d | %.1f %% | %.1f %% | %.1f %% |\n",
                            least, found ? ", found when searched" : "", count, percent(searched),
                            percent(accepted), percent(joined));
    }
  }
  const auto wrong =
      std::count_if(results.pairs.begin(), results.pairs.end(),
                    [](const ComparedPair& pair) { return pair.is_accepted && pair.overlap == 0; });
  absl::StrAppend(&table, "\nAccepted with nothing in common: ", wrong, ".\n");
  return table;
}

}  // namespace

std::string PlaceIndexTable(const IndexResults& results) {
  const auto overlapping = [&](double least) {
    return std::count_if(results.pairs.begin(), results.pairs.end(),
                         [&](const ComparedPair& pair) { return pair.overlap >= least; });
  };
  std::string table = absl::StrCat(
      results.sessions, " sessions, ", results.pairs.size(), " pairs, of which ", overlapping(0.15),
      " overlap by 0.15 and more, ", overlapping(0.3),
      " by 0.3.\n\n| searched | of all pairs | recall from 0.15 on | from 0.3 on | median kind "
      "(worst), from 0.3 on | joined |\n|---|---|---|---|---|---|\n");
  for (const double share : {0.02, 0.05, 0.1, 0.2, 0.5}) {
    table += Row(results, absl::StrCat("likeliest ", 100 * share, " %"),
                 [&](const ComparedPair& pair) { return pair.place < share; });
  }
  for (const size_t partners : kPartnerCounts) {
    table += Row(results, absl::StrCat(partners, " partners"),
                 [&](const ComparedPair& pair) { return pair.partners.contains(partners); });
  }
  table += "\n" + KindTable(results);
  const double compare_ms =
      std::accumulate(results.compare_ms.begin(), results.compare_ms.end(), 0.0);
  absl::StrAppendFormat(
      &table,
      "\nCPU time: a plan %.0f ms (%.0f), %.0f kB; a comparison %.0f ms (%.0f); a session against "
      "all others %.1f s.\n",
      Median(results.plan_ms), Worst(results.plan_ms),
      static_cast<double>(results.bytes) / 1e3 / static_cast<double>(results.sessions),
      Median(results.compare_ms), Worst(results.compare_ms),
      2 * compare_ms / 1e3 / static_cast<double>(results.sessions));
  return results.server ? table + ServerTable(results) : table;
}

}  // namespace isthmus::bench
