#include "lab/loadgen/load_report.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace isthmus::loadgen {
namespace {

// All of them as one.
RobotResult Together(const std::vector<RobotResult>& robots) {
  RobotResult all;
  for (const RobotResult& robot : robots) {
    all.pushed += robot.pushed;
    all.processed += robot.processed;
    all.rejected += robot.rejected;
    all.duplicates += robot.duplicates;
    all.skipped += robot.skipped;
    all.unanswered += robot.unanswered;
    all.late += robot.late;
    all.reconnects += robot.reconnects;
    all.cloud_bytes += robot.cloud_bytes;
    all.lost += robot.lost;
    all.most_undurable = std::max(all.most_undurable, robot.most_undurable);
    all.finish_s = std::max(all.finish_s, robot.finish_s);
    all.ack_ms.insert(all.ack_ms.end(), robot.ack_ms.begin(), robot.ack_ms.end());
    all.odometry_ms.insert(all.odometry_ms.end(), robot.odometry_ms.begin(),
                           robot.odometry_ms.end());
    if (all.first_rejection.empty()) all.first_rejection = robot.first_rejection;
    all.status.Update(robot.status);
  }
  return all;
}

// The server's computing time per scan that took effect, milliseconds.
double CpuPerScanMs(const LoadResult& result, const RobotResult& all) {
  if (result.server.empty() || all.processed == 0) return 0;
  const double cpu_s = result.server.back().use.cpu_s - result.server.front().use.cpu_s;
  return 1e3 * cpu_s / static_cast<double>(all.processed);
}

// Kilobytes a second of each robot while it sent.
double WireKbS(const LoadResult& result, const RobotResult& all) {
  const double s = result.seconds * static_cast<double>(result.robots.size());
  return s > 0 ? static_cast<double>(all.cloud_bytes) / 1e3 / s : 0;
}

// The highest of the second half of the run, and how far that is above the highest of the second
// quarter: what still grows once all is warm.
struct Growth {
  double most = 0, grown = 0;
};
template <typename Value>
Growth GrowthOf(const std::vector<ServerUse>& uses, const Value& value) {
  Growth growth;
  double early = 0;
  for (size_t i = 0; i < uses.size(); ++i) {
    const double x = value(uses[i].use);
    growth.most = std::max(growth.most, x);
    if (i >= uses.size() / 4 && i < uses.size() / 2) early = std::max(early, x);
  }
  growth.grown = growth.most - early;
  return growth;
}

std::string Line(const std::string& what, const Spread& spread, size_t count) {
  return absl::StrFormat("%-22s p50 %8.1f  p90 %8.1f  p99 %8.1f  max %8.1f ms  (%d)\n", what,
                         spread.p50, spread.p90, spread.p99, spread.max, count);
}

std::string ThreadsText(const LoadResult& result, const RobotResult& all) {
  std::string text;
  for (const auto& [name, cpu_s] : result.thread_cpu_s) {
    const double ms = 1e3 * cpu_s / static_cast<double>(std::max<uint64_t>(all.processed, 1));
    if (ms >= 0.05) absl::StrAppendFormat(&text, "  %-20s %.2f ms of CPU a scan\n", name, ms);
  }
  return text;
}

std::string BesideText(const LoadResult& result) {
  if (result.beside.empty()) return {};
  const RobotResult all = Together(result.beside);
  return absl::StrFormat("beside them            %d scans pushed, %d processed, %d rejected\n",
                         all.pushed, all.processed, all.rejected) +
         Line("  acknowledgement", SpreadOf(all.ack_ms), all.ack_ms.size());
}

std::string MisbehavingClientsText(const LoadResult& result) {
  std::string text;
  if (result.knocks + result.knocks_refused > 0) {
    absl::StrAppendFormat(&text, "connections            %d made and dropped, %d refused\n",
                          result.knocks, result.knocks_refused);
  }
  const MisbehavingClientResult& is = result.misbehaving;
  if (is.closed + is.not_made > 0) {
    absl::StrAppendFormat(&text, "held connections       %d closed by the server, %d refused\n",
                          is.closed, is.not_made);
  }
  if (is.pieces + is.cut_off > 0) {
    absl::StrAppendFormat(&text, "slow readers           %d pieces read, %d times cut off\n",
                          is.pieces, is.cut_off);
  }
  if (is.malformed + is.tolerated + is.unanswered > 0) {
    absl::StrAppendFormat(&text,
                          "malformed streams      %d rejected, %d taken, %d without an answer\n",
                          is.malformed, is.tolerated, is.unanswered);
  }
  return text;
}

std::string ServerText(const LoadResult& result, const RobotResult& all) {
  if (result.server.empty()) return {};
  const Growth memory = GrowthOf(result.server, [](auto& use) { return use.resident_mb; });
  const Growth threads = GrowthOf(result.server, [](auto& use) { return double(use.threads); });
  const Growth files = GrowthOf(result.server, [](auto& use) { return double(use.files); });
  const double cpu_s = result.server.back().use.cpu_s - result.server.front().use.cpu_s;
  return absl::StrFormat(
      "server                 %.2f cores, %.2f ms of CPU a scan, %.0f MB (%+.0f in the second "
      "half), "
      "%.0f threads (%+.0f), %.0f files, %.0f MB of disk\n",
      cpu_s / result.seconds, CpuPerScanMs(result, all), memory.most, memory.grown, threads.most,
      threads.grown, files.most, result.disk_mb);
}

cli::Json ToJson(const Spread& spread) {
  return {{"p50", spread.p50}, {"p90", spread.p90}, {"p99", spread.p99}, {"max", spread.max}};
}

}  // namespace

Spread SpreadOf(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    const auto rank = static_cast<size_t>(std::ceil(share * static_cast<double>(values.size())));
    return values[std::max<size_t>(rank, 1) - 1];
  };
  return {at(0.5), at(0.9), at(0.99), values.back()};
}

std::string ToText(const LoadResult& result) {
  const RobotResult all = Together(result.robots);
  std::string text = absl::StrFormat(
      "%d robots, %.0f s: %d scans pushed, %d processed, %d skipped, %d rejected, %d without an "
      "answer; %d "
      "pushed late, %d not followed, %d reconnects\n",
      result.robots.size(), result.seconds, all.pushed, all.processed, all.skipped, all.rejected,
      all.unanswered, all.late, all.lost, all.reconnects);
  text += Line("acknowledgement", SpreadOf(all.ack_ms), all.ack_ms.size());
  text += Line("odometry", SpreadOf(all.odometry_ms), all.odometry_ms.size());
  for (const auto& [name, reader] : result.readers) {
    text += Line(name, SpreadOf(reader.ms), reader.ms.size());
    for (const auto& [message, count] : reader.errors) {
      absl::StrAppend(&text, "  ", count, " times: ", message, "\n");
    }
  }
  absl::StrAppendFormat(
      &text, "wire                   %.0f kB/s a robot; not yet durable: %d scans at most\n",
      WireKbS(result, all), all.most_undurable);
  text += BesideText(result);
  text += ServerText(result, all);
  text += ThreadsText(result, all);
  absl::StrAppendFormat(&text, "this generator         %.2f cores\n",
                        result.generator_cpu_s / result.seconds);
  text += MisbehavingClientsText(result);
  if (!all.first_rejection.empty()) {
    absl::StrAppend(&text, "first rejection: ", all.first_rejection, "\n");
  }
  for (const RobotResult& robot : result.robots) {
    if (!robot.status.ok()) absl::StrAppend(&text, robot.name, ": ", robot.status.message(), "\n");
  }
  return text;
}

cli::Json ToJson(const LoadResult& result) {
  const RobotResult all = Together(result.robots);
  cli::Json json = {{"robots", result.robots.size()},
                    {"seconds", result.seconds},
                    {"pushed", all.pushed},
                    {"processed", all.processed},
                    {"skipped", all.skipped},
                    {"rejected", all.rejected},
                    {"unanswered", all.unanswered},
                    {"late", all.late},
                    {"not_followed", all.lost},
                    {"reconnects", all.reconnects},
                    {"acknowledgement_ms", ToJson(SpreadOf(all.ack_ms))},
                    {"odometry_ms", ToJson(SpreadOf(all.odometry_ms))},
                    {"wire_kb_s", WireKbS(result, all)},
                    {"most_undurable", all.most_undurable},
                    {"generator_cores", result.generator_cpu_s / result.seconds},
                    {"knocks", result.knocks},
                    {"knocks_refused", result.knocks_refused},
                    {"held_closed", result.misbehaving.closed},
                    {"held_refused", result.misbehaving.not_made},
                    {"slow_pieces", result.misbehaving.pieces},
                    {"slow_cut_off", result.misbehaving.cut_off},
                    {"malformed_rejected", result.misbehaving.malformed},
                    {"malformed_taken", result.misbehaving.tolerated},
                    {"malformed_unanswered", result.misbehaving.unanswered}};
  for (const auto& [name, reader] : result.readers) {
    int errors = 0;
    for (const auto& [message, count] : reader.errors) errors += count;
    json["readers"][name] = {
        {"answers", reader.ms.size()}, {"errors", errors}, {"ms", ToJson(SpreadOf(reader.ms))}};
  }
  if (!result.server.empty()) {
    const double cpu_s = result.server.back().use.cpu_s - result.server.front().use.cpu_s;
    json["server"] = {{"cores", cpu_s / result.seconds},
                      {"cpu_per_scan_ms", CpuPerScanMs(result, all)},
                      {"disk_mb", result.disk_mb},
                      {"thread_cpu_s", result.thread_cpu_s}};
    for (const ServerUse& one : result.server) {
      json["server"]["seconds"].push_back({{"at", one.at_s},
                                           {"resident_mb", one.use.resident_mb},
                                           {"threads", one.use.threads},
                                           {"files", one.use.files}});
    }
  }
  for (const RobotResult& robot : result.robots) {
    json["each"].push_back({{"robot", robot.name},
                            {"pushed", robot.pushed},
                            {"processed", robot.processed},
                            {"acknowledgement_ms", ToJson(SpreadOf(robot.ack_ms))},
                            {"error", std::string(robot.status.message())}});
  }
  return json;
}

bool AllAnswered(const LoadResult& result) {
  const RobotResult all = Together(result.robots);
  return all.status.ok() && all.unanswered == 0;
}

}  // namespace isthmus::loadgen
