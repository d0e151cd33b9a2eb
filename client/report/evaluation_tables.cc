#include "client/report/evaluation_tables.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include <utility>

#include "client/report/error_json.h"

namespace isthmus::report {
namespace {

using evaluation::Alignment;
using evaluation::DeltaUnit;
using evaluation::DriftErrors;
using evaluation::ErrorStatistics;
using evaluation::EvaluatedTrajectory;
using evaluation::Evaluation;
using evaluation::Statistics;

std::string Metres(double value) { return absl::StrFormat("%.4f", value); }
std::string Degrees(double value) { return absl::StrFormat("%.3f", value); }

std::vector<std::string> AbsoluteRow(const std::string& name, const ErrorStatistics& e) {
  return {name,
          absl::StrCat(e.count),
          Metres(e.rmse_m),
          Metres(e.mean_m),
          Metres(e.median_m),
          Metres(e.std_m),
          Metres(e.max_m),
          Degrees(e.rotation_deg.rmse),
          Degrees(e.rotation_deg.median),
          Degrees(e.rotation_deg.max)};
}

Table AbsoluteTable(const Evaluation& evaluation) {
  Table table{"Absolute trajectory error (ATE)",
              {"", "poses", "rmse m", "mean m", "median m", "std m", "max m", "rotation rmse deg",
               "median deg", "max deg"},
              {}};
  for (const EvaluatedTrajectory& robot : evaluation.robots) {
    table.rows.push_back(AbsoluteRow(robot.name, robot.absolute));
  }
  if (evaluation.all) table.rows.push_back(AbsoluteRow("all in one frame", *evaluation.all));
  return table;
}

void AddRelativeRow(const std::string& name, const std::string& per, const Statistics& m,
                    const Statistics& deg, Table* table) {
  if (m.count == 0) return;
  table->rows.push_back({name, per, absl::StrCat(m.count), Metres(m.rmse), Metres(m.mean),
                         Metres(m.median), Metres(m.std), Metres(m.max), Degrees(deg.rmse),
                         Degrees(deg.median), Degrees(deg.max)});
}

Table RelativeTable(const Evaluation& evaluation) {
  Table table{"Relative pose error (RPE)",
              {"", "per", "pairs", "rmse m", "mean m", "median m", "std m", "max m",
               "rotation rmse deg", "median deg", "max deg"},
              {},
              2};
  for (const EvaluatedTrajectory& robot : evaluation.robots) {
    AddRelativeRow(robot.name, "frame", robot.per_frame.m, robot.per_frame.deg, &table);
    AddRelativeRow(robot.name, DeltaText(evaluation.options.delta), robot.per_delta.m,
                   robot.per_delta.deg, &table);
  }
  return table;
}

std::string LengthText(double length_m) { return absl::StrFormat("%g m", length_m); }

Table DriftTable(const Evaluation& evaluation) {
  Table table{"Relative pose error by length of segment",
              {"", "length", "segments", "mean %", "median %", "max %", "mean deg/100m",
               "median deg/100m", "max deg/100m"},
              {},
              2};
  for (const EvaluatedTrajectory& robot : evaluation.robots) {
    const DriftErrors& drift = robot.drift;
    size_t count = 0;
    for (const evaluation::SegmentErrors& errors : drift.lengths) {
      const Statistics percent = evaluation::Summarize(errors.percent);
      const Statistics deg = evaluation::Summarize(errors.deg_per_100m);
      count += percent.count;
      table.rows.push_back({robot.name, LengthText(errors.length_m), absl::StrCat(percent.count),
                            Degrees(percent.mean), Degrees(percent.median), Degrees(percent.max),
                            Degrees(deg.mean), Degrees(deg.median), Degrees(deg.max)});
    }
    if (count == 0) continue;
    table.rows.push_back({robot.name, "all", absl::StrCat(count), Degrees(drift.percent), "", "",
                          Degrees(drift.deg_per_100m), "", ""});
  }
  return table;
}

std::string AlignmentText(const Evaluation& evaluation) {
  const char* together = evaluation.options.merged ? "all together" : "each by itself";
  switch (evaluation.options.alignment) {
    case Alignment::kNone:
      return "Alignment: none; truth and estimate are compared as they are.";
    case Alignment::kFirstPose:
      return absl::StrCat("Alignment: the first pair of poses is made to coincide, ", together,
                          "; no scale.");
    case Alignment::kRigid:
      break;
  }
  return absl::StrCat("Alignment: rotation and translation by least squares over all positions ",
                      "(Umeyama), ", together, "; no scale.");
}

std::string SegmentsText(const EvaluatedTrajectory& robot) {
  const DriftErrors& drift = robot.drift;
  if (drift.lengths.empty()) {
    return absl::StrFormat("%s: %.1f m are too short for segments.", robot.name, robot.way_m);
  }
  if (drift.is_kitti) {
    return absl::StrFormat(
        "%s: KITTI's segments of %s to %s of its %.0f m, begun at every %dth pose.", robot.name,
        LengthText(drift.lengths.front().length_m), LengthText(drift.lengths.back().length_m),
        robot.way_m, drift.stride);
  }
  return absl::StrFormat(
      "%s: its %.1f m are too short for KITTI's segments of 100 to 800 m; segments of %s to %s, "
      "begun at every pose, are not comparable with KITTI's table.",
      robot.name, robot.way_m, LengthText(drift.lengths.front().length_m),
      LengthText(drift.lengths.back().length_m));
}

cli::Json StatisticsJson(const Statistics& s) {
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median},
          {"std", s.std},   {"min", s.min},   {"max", s.max}};
}

cli::Json RelativeJson(const evaluation::RelativeErrors& errors) {
  if (errors.m.count == 0) return nullptr;
  return {{"pairs", errors.m.count},
          {"translation_m", StatisticsJson(errors.m)},
          {"rotation_deg", StatisticsJson(errors.deg)}};
}

cli::Json DriftJson(const DriftErrors& drift) {
  cli::Json out = {{"kitti", drift.is_kitti},
                   {"stride", drift.stride},
                   {"translation_percent", drift.percent},
                   {"rotation_deg_per_100m", drift.deg_per_100m},
                   {"lengths", cli::Json::array()}};
  for (const evaluation::SegmentErrors& errors : drift.lengths) {
    out["lengths"].push_back(
        {{"length_m", errors.length_m},
         {"segments", errors.percent.size()},
         {"translation_percent", StatisticsJson(evaluation::Summarize(errors.percent))},
         {"rotation_deg_per_100m", StatisticsJson(evaluation::Summarize(errors.deg_per_100m))}});
  }
  return out;
}

}  // namespace

std::string DeltaText(const evaluation::Delta& delta) {
  const char* unit = delta.unit == DeltaUnit::kMetres    ? "m"
                     : delta.unit == DeltaUnit::kSeconds ? "s"
                     : delta.value == 1                  ? "frame"
                                                         : "frames";
  return absl::StrFormat("%g %s", delta.value, unit);
}

std::vector<std::string> MethodOf(const Evaluation& evaluation) {
  std::vector<std::string> out;
  std::vector<std::string> counts;
  for (const EvaluatedTrajectory& robot : evaluation.robots) {
    counts.push_back(absl::StrFormat("%s %d of %d estimated (%d true, %.1f m, %.1f s)", robot.name,
                                     robot.pairs.size(), robot.estimate_poses, robot.truth.size(),
                                     robot.way_m, robot.duration_s));
  }
  out.push_back(absl::StrFormat("Poses paired, nearest in time and at most %g s apart: %s.",
                                evaluation.options.tolerance_s, absl::StrJoin(counts, "; ")));
  out.push_back(AlignmentText(evaluation));
  out.push_back(absl::StrCat("RPE: from every pose to the next, and to the first at least ",
                             DeltaText(evaluation.options.delta), " on; no alignment changes it."));
  for (const EvaluatedTrajectory& robot : evaluation.robots) out.push_back(SegmentsText(robot));
  return out;
}

std::vector<Table> TablesOf(const Evaluation& evaluation) {
  std::vector<Table> tables = {AbsoluteTable(evaluation), RelativeTable(evaluation),
                               DriftTable(evaluation)};
  std::erase_if(tables, [](const Table& table) { return table.rows.empty(); });
  return tables;
}

cli::Json JsonOf(const Evaluation& evaluation) {
  const evaluation::EvaluationOptions& options = evaluation.options;
  const char* names[] = {"none", "first", "rigid"};
  const char* units[] = {"frames", "m", "s"};
  cli::Json out = {
      {"alignment", names[static_cast<int>(options.alignment)]},
      {"scale", 1},
      {"tolerance_s", options.tolerance_s},
      {"delta",
       {{"value", options.delta.value}, {"unit", units[static_cast<int>(options.delta.unit)]}}},
      {"robots", cli::Json::array()}};
  for (const EvaluatedTrajectory& robot : evaluation.robots) {
    cli::Json one = {{"name", robot.name}};
    one.update(cli::ToJson(robot.absolute));
    one["truth_poses"] = robot.truth.size();
    one["estimate_poses"] = robot.estimate_poses;
    one["way_m"] = robot.way_m;
    one["duration_s"] = robot.duration_s;
    one["T_truth_estimate"] = cli::ToJson(robot.T_truth_estimate);
    one["per_frame"] = RelativeJson(robot.per_frame);
    one["per_delta"] = RelativeJson(robot.per_delta);
    one["segments"] = DriftJson(robot.drift);
    out["robots"].push_back(std::move(one));
  }
  out["merged"] = evaluation.all ? cli::ToJson(*evaluation.all) : cli::Json(nullptr);
  return out;
}

}  // namespace isthmus::report
