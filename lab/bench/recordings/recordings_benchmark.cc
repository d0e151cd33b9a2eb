// The speed of reading a recording, and the distance of its points from another program's.
#include <absl/strings/str_format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/readers/packets/pcap_recording.h"
#include "client/readers/recording.h"
#include "core/codec/payload_layout.h"
#include "lab/bench/cpu_clock.h"
#include "lab/bench/recordings/nebula_azimuths.h"
#include "lab/bench/recordings/ouster_digest.h"
#include "lab/bench/recordings/reference_cloud.h"

namespace isthmus::bench {
namespace {

using readers::RecordedScan;

// Same range and height, to the last digit of the reference's float32 and its sines.
constexpr double kSamePoint = 0.002;

struct Options {
  std::string recording, reference, digest;
  size_t topic = 0;
  int repeats = 1;
  bool scans = false, rings = false, like_nebula = false;
  readers::ReadOptions read;
};

struct Reading {
  size_t scans = 0, points = 0;
  double cpu_ms = 0;  // One thread's.
  int64_t first_ns = 0, last_ns = 0;
  PointList list;
  std::vector<std::string> assumptions, errors;
  std::string sensor;
};

int Fail(const absl::Status& status) {
  absl::FPrintF(stderr, "%s\n", status.message());
  return 1;
}

void Take(const Options& options, bool tell, RecordedScan scan, Reading& reading) {
  if (reading.scans++ == 0) reading.first_ns = scan.end_stamp_ns;
  reading.last_ns = scan.end_stamp_ns;
  reading.points += codec::PointCount(scan.payload);
  if (options.scans && tell) {
    absl::PrintF("%s: END %d.%09d, %d points\n", scan.name, scan.end_stamp_ns / 1'000'000'000,
                 scan.end_stamp_ns % 1'000'000'000, codec::PointCount(scan.payload));
  }
  if (!options.reference.empty()) (void)reading.list.Append(scan.payload);
}

absl::StatusOr<Reading> Read(const readers::Recording& recording, const Options& options,
                             bool tell) {
  Reading reading;
  const CpuClock open_clock;
  absl::StatusOr<std::unique_ptr<readers::ScanReader>> reader =
      recording.OpenScans(options.topic, options.read);
  if (!reader.ok()) return reader.status();
  reading.cpu_ms = open_clock.Ms();
  while (true) {
    const CpuClock clock;
    absl::StatusOr<std::optional<RecordedScan>> scan = (*reader)->Next();
    reading.cpu_ms += clock.Ms();
    if (!scan.ok()) {
      reading.errors.emplace_back(scan.status().message());
      continue;
    }
    if (!*scan) break;
    Take(options, tell, **std::move(scan), reading);
  }
  reading.assumptions = (*reader)->Assumptions();
  reading.sensor = (*reader)->sensor();
  return reading;
}

void PrintReading(const Reading& reading, double survey_ms) {
  for (const std::string& text : reading.assumptions) absl::PrintF("  taken: %s\n", text);
  for (const std::string& text : reading.errors) absl::PrintF("  error: %s\n", text);
  const double recorded_s = reading.scans > 1
                                ? static_cast<double>(reading.last_ns - reading.first_ns) * 1e-9 *
                                      static_cast<double>(reading.scans) /
                                      static_cast<double>(reading.scans - 1)
                                : 0;
  absl::PrintF("%s: %d scans, %d points, %.3f s recorded\n", reading.sensor, reading.scans,
               reading.points, recorded_s);
  absl::PrintF("one thread: survey %.2f ms, reading %.2f ms, %.2f million points a second",
               survey_ms, reading.cpu_ms,
               static_cast<double>(reading.points) / reading.cpu_ms * 1e-3);
  if (recorded_s > 0) {
    absl::PrintF(", %.0f times real time (with the survey: %.0f)",
                 recorded_s * 1e3 / reading.cpu_ms,
                 recorded_s * 1e3 / (reading.cpu_ms + survey_ms));
  }
  absl::PrintF("\n");
}

void PrintSpread(const char* what, std::vector<double> values, double scale, const char* unit) {
  if (values.empty()) return;
  std::sort(values.begin(), values.end());
  const auto at = [&](double q) {
    return values[static_cast<size_t>(q * static_cast<double>(values.size() - 1))] * scale;
  };
  absl::PrintF("  %-22s min %.4f, 1 %% %.4f, median %.4f, 99 %% %.4f, max %.4f %s\n", what, at(0),
               at(0.01), at(0.5), at(0.99), at(1), unit);
}

void PrintAgreement(const Agreement& agreement, bool rings) {
  absl::PrintF("reference: %d points, matched %d, not in ours %d, ours between them %d, order %s\n",
               agreement.reference_points, agreement.matched,
               agreement.reference_points - agreement.matched, agreement.skipped,
               agreement.same_order ? "equal" : "differs");
  absl::PrintF("  rings equal: %d of %d\n", agreement.rings_equal, agreement.rings_compared);
  PrintSpread("distance", agreement.distance, 1e3, "mm");
  PrintSpread("difference of range", agreement.range, 1e3, "mm");
  PrintSpread("difference of height", agreement.height, 1e3, "mm");
  PrintSpread("azimuth, theirs behind", agreement.azimuth, 1, "degrees");
  if (!rings) return;
  for (const auto& [ring, azimuth] : agreement.azimuth_of_ring) {
    PrintSpread(absl::StrFormat("ring %d", ring).c_str(), azimuth, 1, "degrees");
  }
}

int PrintDigest(const Options& options) {
  const absl::StatusOr<std::vector<DigestLine>> lines =
      CompareDigest(options.recording, options.read.metadata, options.digest);
  if (!lines.ok()) return Fail(lines.status());
  bool same = true;
  for (const DigestLine& line : *lines) {
    same = same && line.same();
    absl::PrintF("  %-16s %s %s\n", line.field, line.ours, line.same() ? "equal" : "DIFFERS");
  }
  return same ? 0 : 1;
}

int Run(const Options& options) {
  const CpuClock clock;
  const absl::StatusOr<std::unique_ptr<readers::Recording>> recording =
      readers::OpenPcapRecording(options.recording);
  if (!recording.ok()) return Fail(recording.status());
  const double survey_ms = clock.Ms();
  for (const readers::ScanTopic& topic : (*recording)->scan_topics()) {
    absl::PrintF("%s: %s, %d packets\n", topic.name, topic.type, topic.messages.value_or(0));
  }
  for (const readers::GnssTopic& topic : (*recording)->gnss_topics()) {
    absl::PrintF("%s: fixes, %d packets\n", topic.name, topic.messages.value_or(0));
  }
  for (const std::string& note : (*recording)->notes()) absl::PrintF("  note: %s\n", note);
  std::optional<Reading> best;
  for (int i = 0; i < options.repeats; ++i) {
    absl::StatusOr<Reading> reading = Read(**recording, options, i == 0);
    if (!reading.ok()) return Fail(reading.status());
    if (!best || reading->cpu_ms < best->cpu_ms) best = *std::move(reading);
  }
  PrintReading(*best, survey_ms);
  if (!options.reference.empty()) {
    const absl::StatusOr<PointList> reference = ReadReference(options.reference);
    if (!reference.ok()) return Fail(reference.status());
    PrintAgreement(Compare(*reference, best->list, kSamePoint), options.rings);
    if (options.like_nebula) {
      const absl::StatusOr<PointList> like =
          ReadLikeNebula(options.recording, options.read.calibration);
      if (!like.ok()) return Fail(like.status());
      absl::PrintF("with nebula's azimuths, ");
      PrintAgreement(Compare(*reference, *like, kSamePoint), options.rings);
    }
  }
  return options.digest.empty() ? 0 : PrintDigest(options);
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) {
  isthmus::bench::Options options;
  CLI::App app{"How fast a capture is read, and how far its points are from another program's."};
  app.add_option("recording", options.recording, "a .pcap file")->required();
  app.add_option("--reference", options.reference, "a .pcd that another program decoded of it");
  app.add_option("--digest", options.digest, "ouster-sdk's _digest.json of it");
  app.add_option("--metadata", options.read.metadata, "Ouster's metadata");
  app.add_option("--calibration", options.read.calibration, "Velodyne's calibration");
  app.add_option("--sensor", options.read.sensor, "the model, where packets do not tell");
  app.add_option("--topic", options.topic, "the sensor, counted from 0");
  app.add_option("--repeats", options.repeats, "reads so often, and tells the fastest")
      ->check(CLI::Range(1, 1000));
  app.add_flag("--like-nebula", options.like_nebula,
               "compares also with nebula's way to interpolate azimuths");
  app.add_flag("--scans", options.scans, "tells each scan");
  app.add_flag("--rings", options.rings, "tells the azimuths of each ring");
  CLI11_PARSE(app, argc, argv);
  return isthmus::bench::Run(options);
}
