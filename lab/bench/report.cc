#include "lab/bench/report.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>

namespace isthmus::bench {
namespace {

using Json = nlohmann::ordered_json;

template <typename Value>
Json OrNull(const std::optional<Value>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json CostJson(const Summary& summary) {
  const CostSummary& cost = summary.cost;
  const auto cal = [&](double ms) { return ms / summary.cal_ms; };
  return {
      {"ms", {{"median", cost.median_ms}, {"p99", cost.p99_ms}, {"max", cost.max_ms}}},
      {"cal",
       {{"median", cal(cost.median_ms)}, {"p99", cal(cost.p99_ms)}, {"max", cal(cost.max_ms)}}},
      {"stages_ms",
       {{"features", cost.features_ms}, {"matching", cost.matching_ms}, {"map", cost.map_ms}}},
      {"scans_200_300_ms", OrNull(cost.early_ms)},
      {"last_100_ms", OrNull(cost.late_ms)},
      {"lost_ratio", OrNull(cost.lost_ratio)},
  };
}

Json ErrorJson(const ErrorSummary& error) {
  return {
      {"rigid", {{"rmse_m", error.rmse_m}, {"worst_m", error.worst_m}, {"final_m", error.last_m}}},
      {"first_pose",
       {{"rmse_m", error.first_rmse_m},
        {"worst_m", error.first_worst_m},
        {"final_m", error.final_m},
        {"heading_rmse_deg", error.heading_rmse_deg},
        {"heading_worst_deg", error.heading_worst_deg},
        {"tilt_rmse_deg", error.tilt_rmse_deg},
        {"tilt_worst_deg", error.tilt_worst_deg}}},
  };
}

Json CountJson(const CountSummary& counts) {
  return {{"ok", counts.ok},
          {"degenerate", counts.degenerate},
          {"lost", counts.lost},
          {"rejected", counts.rejected},
          {"silent", counts.silent},
          {"covered_ok", counts.covered_ok},
          {"segments", counts.segments}};
}

Json LapsJson(const std::vector<LapSummary>& laps) {
  Json rows = Json::array();
  for (const LapSummary& lap : laps) {
    rows.push_back(
        {{"median_ms", lap.median_ms}, {"odometry_mb", lap.odometry_mb}, {"rmse_m", lap.rmse_m}});
  }
  return rows;
}

// All runs of one scenario.
using Group = std::vector<const Entry*>;

std::vector<Group> ByScenario(const std::vector<Entry>& entries) {
  std::vector<Group> groups;
  for (const Entry& entry : entries) {
    if (groups.empty() || groups.back()[0]->scenario != entry.scenario) groups.emplace_back();
    groups.back().push_back(&entry);
  }
  return groups;
}

template <typename Figure>
double Median(const Group& group, Figure figure) {
  std::vector<double> values;
  for (const Entry* entry : group) values.push_back(figure(entry->summary));
  return Percentile(values, 0.5);
}

template <typename Figure>
double Worst(const Group& group, Figure figure) {
  double worst = figure(group[0]->summary);
  for (const Entry* entry : group) worst = std::max(worst, double(figure(entry->summary)));
  return worst;
}

template <typename Figure>
int Sum(const Group& group, Figure figure) {
  int sum = 0;
  for (const Entry* entry : group) sum += figure(entry->summary);
  return sum;
}

std::string Growth(const Group& group) {
  const auto has = [](const Entry* e) {
    return e->summary.cost.early_ms && e->summary.cost.late_ms;
  };
  if (!std::all_of(group.begin(), group.end(), has)) return "–";
  const double growth = Median(group, [](const Summary& s) {
    return *s.cost.early_ms > 0 ? *s.cost.late_ms / *s.cost.early_ms - 1 : 0;
  });
  return absl::StrFormat("%+.0f %%", 100 * growth);
}

std::string Recovery(const Group& group) {
  if (!group[0]->summary.scans_to_recover) return "–";
  std::vector<std::string> each;
  for (const Entry* entry : group) {
    const int scans = entry->summary.scans_to_recover.value_or(-1);
    each.push_back(scans < 0 ? "never" : absl::StrCat(scans));
  }
  std::sort(each.begin(), each.end());
  each.erase(std::unique(each.begin(), each.end()), each.end());
  std::string text;
  for (const std::string& one : each) absl::StrAppend(&text, text.empty() ? "" : "/", one);
  return text;
}

std::string Row(const Group& group) {
  const auto cal = [](double CostSummary::*ms) {
    return [ms](const Summary& s) { return s.cost.*ms / s.cal_ms; };
  };
  const auto cost = [](double CostSummary::*ms) {
    return [ms](const Summary& s) { return s.cost.*ms; };
  };
  const auto error = [](double ErrorSummary::*metres) {
    return [metres](const Summary& s) { return s.error.*metres; };
  };
  const auto count = [](int CountSummary::*scans) {
    return [scans](const Summary& s) { return s.counts.*scans; };
  };
  return absl::StrFormat(
      "| %s | %d | %.2f | %.4f | %.4f | %.4f | %.2f / %.2f / %.2f | %s | %.4f | %.3f | %.3f | %.3f "
      "| %.2f "
      "| %.2f | %d / %d / %d / %d | %d | %s | %.0f |\n",
      group[0]->scenario, group.size(), Median(group, cost(&CostSummary::median_ms)),
      Median(group, cal(&CostSummary::median_ms)), Median(group, cal(&CostSummary::p99_ms)),
      Worst(group, cal(&CostSummary::max_ms)), Median(group, cost(&CostSummary::features_ms)),
      Median(group, cost(&CostSummary::matching_ms)), Median(group, cost(&CostSummary::map_ms)),
      Growth(group), Worst(group, error(&ErrorSummary::rmse_m)),
      Worst(group, error(&ErrorSummary::worst_m)), Worst(group, error(&ErrorSummary::last_m)),
      Worst(group, error(&ErrorSummary::final_m)),
      Worst(group, error(&ErrorSummary::heading_worst_deg)),
      Worst(group, error(&ErrorSummary::tilt_worst_deg)), Sum(group, count(&CountSummary::ok)),
      Sum(group, count(&CountSummary::degenerate)), Sum(group, count(&CountSummary::lost)),
      Sum(group, count(&CountSummary::rejected)), Sum(group, count(&CountSummary::silent)),
      Recovery(group), Worst(group, [](const Summary& s) { return s.odometry_mb; }));
}

std::string CorridorTable(const std::vector<Entry>& entries) {
  std::string table;
  for (const Entry& entry : entries) {
    if (!entry.summary.corridor) continue;
    const CorridorSummary& c = *entry.summary.corridor;
    absl::StrAppendFormat(&table, "| %d | %.2f | %.3f | %.3f | %.2f | %.0f %% |\n", entry.seed,
                          c.along_worst_m, c.across_worst_m, c.height_worst_m, c.heading_worst_deg,
                          100 * c.flagged);
  }
  if (table.empty()) return table;
  return absl::StrCat(
      "\n| corridor, seed | along m | across m | height m | heading deg | flagged along it |\n"
      "|---|---|---|---|---|---|\n",
      table);
}

std::string LapTable(const std::vector<Entry>& entries) {
  std::string table;
  for (const Entry& entry : entries) {
    const std::vector<LapSummary>& laps = entry.summary.laps;
    for (size_t i = 0; i < laps.size(); i += std::max<size_t>(1, laps.size() / 10)) {
      absl::StrAppendFormat(&table, "| %d | %.2f | %.1f | %.3f |\n", i + 1, laps[i].median_ms,
                            laps[i].odometry_mb, laps[i].rmse_m);
    }
  }
  if (table.empty()) return table;
  return absl::StrCat(
      "\n| lap | ms | odometry MB | RMSE m (from first pose) |\n|---|---|---|---|\n", table);
}

}  // namespace

nlohmann::ordered_json ToJson(const Entry& entry) {
  const Summary& summary = entry.summary;
  Json json = {{"scenario", entry.scenario},
               {"mode", entry.mode},
               {"sensor", entry.sensor},
               {"seed", entry.seed},
               {"scans", entry.scans},
               {"cal_ms", summary.cal_ms},
               {"cost", CostJson(summary)},
               {"memory_mb", {{"odometry", summary.odometry_mb}, {"peak", summary.peak_mb}}},
               {"error", ErrorJson(summary.error)},
               {"counts", CountJson(summary.counts)},
               {"scans_to_recover", OrNull(summary.scans_to_recover)},
               {"corridor", nullptr},
               {"laps", LapsJson(summary.laps)}};
  if (const auto& c = summary.corridor) {
    json["corridor"] = {{"along_worst_m", c->along_worst_m},
                        {"across_worst_m", c->across_worst_m},
                        {"height_worst_m", c->height_worst_m},
                        {"heading_worst_deg", c->heading_worst_deg},
                        {"flagged", c->flagged}};
  }
  return json;
}

std::string ToMarkdown(const std::vector<Entry>& entries) {
  std::string text =
      "| scenario | seeds | ms | cal | cal p99 | cal max | features / matching / map ms | growth | "
      "RMSE m | worst m | final m | from first pose m | heading deg | tilt deg | ok / degenerate / "
      "lost / rejected | "
      "silent | relocalised after | MB |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Group& group : ByScenario(entries)) absl::StrAppend(&text, Row(group));
  return absl::StrCat(text, CorridorTable(entries), LapTable(entries));
}

std::string ToLine(const Entry& entry) {
  const Summary& s = entry.summary;
  return absl::StrFormat(
      "%-15s %2d %-10s %6d scans %6.2f ms %.4f cal (cal %.1f ms) rmse %.4f worst %.3f final %.3f "
      "heading %.2f tilt %.2f ok %d degenerate %d lost %d rejected %d silent %d segments %d%s",
      entry.scenario, entry.seed, entry.mode, entry.scans, s.cost.median_ms,
      s.cost.median_ms / s.cal_ms, s.cal_ms, s.error.rmse_m, s.error.worst_m, s.error.final_m,
      s.error.heading_worst_deg, s.error.tilt_worst_deg, s.counts.ok, s.counts.degenerate,
      s.counts.lost, s.counts.rejected, s.counts.silent, s.counts.segments,
      s.cost.lost_ratio ? absl::StrFormat(" lost scan %.1fx", *s.cost.lost_ratio) : "");
}

}  // namespace isthmus::bench
