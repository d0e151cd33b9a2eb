// The bytes of recorded scans on the wire, and the cost of rounding them and reading them back.
#include <absl/strings/str_format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "client/readers/recording.h"
#include "core/codec/payload_layout.h"
#include "core/codec/quantized.h"
#include "lab/bench/cpu_clock.h"

namespace isthmus::bench {
namespace {

// Costs of one encoding, summed over scans.
struct Sums {
  double bytes = 0, encode_ms = 0, decode_ms = 0;
};

absl::StatusOr<std::vector<PointPayload>> ReadScans(const std::string& path, size_t most) {
  auto recording = readers::OpenRecording(path);
  if (!recording.ok()) return recording.status();
  auto reader = (*recording)->OpenScans(0, {});
  if (!reader.ok()) return reader.status();
  std::vector<PointPayload> scans;
  while (scans.size() < most) {
    auto scan = (*reader)->Next();
    if (!scan.ok()) continue;
    if (!scan->has_value()) break;
    scans.push_back(std::move((*scan)->payload));
  }
  if (scans.empty()) return absl::NotFoundError(path + " has no scans");
  return scans;
}

absl::Status Measure(const PointPayload& raw, double resolution_m, int repeats, int version,
                     Sums* sums) {
  double encode_ms = 1e9, decode_ms = 1e9;
  for (int i = 0; i < repeats; ++i) {
    const CpuClock encoding;
    const auto quantized = codec::Quantize(raw, resolution_m, version);
    encode_ms = std::min(encode_ms, encoding.Ms());
    if (!quantized.ok()) return quantized.status();
    const CpuClock decoding;
    const auto back = codec::Dequantize(*quantized);
    decode_ms = std::min(decode_ms, decoding.Ms());
    if (!back.ok()) return back.status();
    if (i == 0) sums->bytes += static_cast<double>(quantized->data.size());
  }
  sums->encode_ms += encode_ms;
  sums->decode_ms += decode_ms;
  return absl::OkStatus();
}

absl::Status Run(const std::string& path, size_t most, double resolution_m, int repeats) {
  const auto scans = ReadScans(path, most);
  if (!scans.ok()) return scans.status();
  Sums sums[2];
  double points = 0;
  for (const PointPayload& raw : *scans) {
    points += static_cast<double>(codec::PointCount(raw));
    for (int version : {1, 2}) {
      if (auto status = Measure(raw, resolution_m, repeats, version, &sums[version - 1]);
          !status.ok()) {
        return status;
      }
    }
  }
  const double n = static_cast<double>(scans->size());
  absl::PrintF("%-40s %4.0f %7.0f", path.substr(path.size() > 40 ? path.size() - 40 : 0), n,
               points / n);
  for (const Sums& sum : sums) {
    absl::PrintF(" | %7.1f %6.2f %6.2f %6.2f", sum.bytes / n / 1000, 8 * sum.bytes / points,
                 sum.encode_ms / n, sum.decode_ms / n);
  }
  absl::PrintF(" | %.3f %.2f %.2f\n", sums[1].bytes / sums[0].bytes,
               sums[1].encode_ms / sums[0].encode_ms, sums[1].decode_ms / sums[0].decode_ms);
  std::fflush(stdout);
  return absl::OkStatus();
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) {
  CLI::App app("Sizes and times of the two versions of the quantised encoding");
  std::vector<std::string> paths;
  size_t scans = 50;
  double resolution_m = 0.002;
  int repeats = 3;
  app.add_option("recordings", paths, "Anything that `isthmus push` reads")->required();
  app.add_option("--scans", scans, "Of each, from the first on")->capture_default_str();
  app.add_option("--resolution", resolution_m, "Step, metres")->capture_default_str();
  app.add_option("--repeats", repeats, "The fastest counts")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  absl::PrintF("%-40s %4s %7s | %31s | %31s | 2 / 1\n", "", "scan", "points",
               "version 1: kB bit enc ms dec ms", "version 2: kB bit enc ms dec ms");
  for (const std::string& path : paths) {
    if (auto status = isthmus::bench::Run(path, scans, resolution_m, std::max(repeats, 1));
        !status.ok()) {
      absl::FPrintF(stderr, "%s: %s\n", path, status.message());
      return 1;
    }
  }
  return 0;
}
