#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <map>

#include "lab/bench/summary.h"
#include "lab/bench/wild/wild_benchmark.h"

namespace isthmus::bench {
namespace {

using Group = std::vector<const WildEntry*>;

template <typename Figure>
std::vector<double> Figures(const Group& group, Figure figure) {
  std::vector<double> values;
  for (const WildEntry* entry : group) values.push_back(figure(entry->score));
  return values;
}

std::string Row(const std::string& name, const Group& group) {
  double scans = 0, lost_long = 0, ok = 0, degenerate = 0;
  int silent = 0, untold = 0, hurt = 0, lost_though_right = 0;
  for (const WildEntry* entry : group) {
    const WildScore& v = entry->score;
    scans += v.scans;
    ok += v.ok;
    degenerate += v.degenerate;
    lost_long += v.lost_long * v.scans;
    lost_though_right += v.lost_though_right;
    silent += v.silent;
    untold += v.silent_untold;
    hurt += v.lost_long > 0 || v.silent > 0;
  }
  const auto percent = Figures(group, [](const WildScore& v) { return v.rmse_percent; });
  const auto ms = Figures(group, [](const WildScore& v) { return v.median_ms; });
  scans = std::max(scans, 1.0);
  return absl::StrFormat(
      "| %s | %d | %d | %.1f | %.1f | %.1f | %d | %.2f | %.2f | %d | %d | %.1f |\n", name,
      group.size(), hurt, 100 * ok / scans, 100 * degenerate / scans, 100 * lost_long / scans,
      lost_though_right, Percentile(percent, 0.5), Percentile(percent, 1), silent, untold,
      Percentile(ms, 0.5));
}

// The worse, the higher.
double Badness(const WildScore& v) {
  const double scans = std::max(v.scans, 1);
  return v.lost_long + v.silent / scans + v.rmse_percent / 100;
}

}  // namespace

std::string ToLine(const WildEntry& entry) {
  const WildScore& v = entry.score;
  return absl::StrFormat(
      "%-9s --kind %s --seed %d %s %s (%s): %d scans, ok %d degenerate %d lost %d (though right "
      "%d) "
      "rejected %d, "
      "longest lost %.1f s, rmse %.3f m = %.2f %% of %.0f m (with degenerate %.2f %%), worst %.2f "
      "m, silent %d (untold %d), "
      "segments %d, %.1f ms = %.4f cal",
      entry.kind, entry.kind, entry.seed, entry.sensor, entry.carrier, entry.about, v.scans, v.ok,
      v.degenerate, v.lost, v.lost_though_right, v.rejected, v.longest_lost_s, v.rmse_m,
      v.rmse_percent, v.path_length_m, v.posed_percent, v.worst_m, v.silent, v.silent_untold,
      v.segments, v.median_ms, v.median_ms / std::max(entry.cal_ms, 1e-9));
}

std::string ToMarkdown(const std::vector<WildEntry>& entries) {
  std::map<std::string, Group> kinds;
  Group all;
  for (const WildEntry& entry : entries) {
    kinds[entry.kind].push_back(&entry);
    all.push_back(&entry);
  }
  std::string text =
      "| kind | drives | of these lost long or silent | ok % | degenerate % | lost > 2 s % | lost "
      "though right | RMSE "
      "% median | "
      "worst | silent scans | untold | ms |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& [name, group] : kinds) absl::StrAppend(&text, Row(name, group));
  absl::StrAppend(&text, Row("all", all));
  constexpr size_t kWorst = 5;
  std::sort(all.begin(), all.end(), [](const WildEntry* a, const WildEntry* b) {
    return Badness(a->score) > Badness(b->score);
  });
  all.resize(std::min(all.size(), kWorst));
  absl::StrAppend(&text, "\nThe worst:\n");
  for (const WildEntry* entry : all) absl::StrAppend(&text, ToLine(*entry), "\n");
  return text;
}

nlohmann::ordered_json ToJson(const WildEntry& entry) {
  const WildScore& v = entry.score;
  return {{"kind", entry.kind},
          {"seed", entry.seed},
          {"sensor", entry.sensor},
          {"carrier", entry.carrier},
          {"about", entry.about},
          {"scans", v.scans},
          {"ok", v.ok},
          {"degenerate", v.degenerate},
          {"lost", v.lost},
          {"lost_though_right", v.lost_though_right},
          {"rejected", v.rejected},
          {"segments", v.segments},
          {"longest_lost_s", v.longest_lost_s},
          {"lost_long", v.lost_long},
          {"path_length_m", v.path_length_m},
          {"rmse_m", v.rmse_m},
          {"rmse_percent", v.rmse_percent},
          {"posed_percent", v.posed_percent},
          {"worst_m", v.worst_m},
          {"silent", v.silent},
          {"silent_untold", v.silent_untold},
          {"median_ms", v.median_ms},
          {"cal_ms", entry.cal_ms}};
}

}  // namespace isthmus::bench
