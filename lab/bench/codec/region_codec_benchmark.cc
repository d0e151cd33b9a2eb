// The bytes of points of the merged map on the wire in each encoding of QueryRegion, and the cost
// of packing them and reading them back.
#include <absl/strings/str_format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "api/convert/cloud.h"
#include "core/codec/draco_cloud.h"
#include "core/codec/quantized.h"
#include "lab/bench/cpu_clock.h"
#include "lab/bench/moving/mapped_drive.h"
#include "server/composition/composer.h"

namespace isthmus::bench {
namespace {

using Chunks = std::vector<std::vector<MapPoint>>;
using Coding = std::function<absl::StatusOr<PointPayload>(const PointPayload&)>;

// Points of a response; as the RPC.
constexpr size_t kChunk = (1 << 20) / sizeof(MapPoint);

absl::StatusOr<Chunks> MakeMap(const DriveOptions& drive) {
  const auto team = MapTeam(drive);
  if (!team.ok()) return team.status();
  composition::Composer composer({.cache_bytes = size_t{4} << 30});
  const auto map = composer.Compose(1, team->placed, team->reader());
  if (!map.ok()) return map.status();
  Chunks chunks;
  const absl::Status status = (*map)->Read({}, kChunk, [&](const std::vector<MapPoint>& points) {
    chunks.push_back(points);
    return true;
  });
  if (!status.ok()) return status;
  return chunks;
}

// The fastest of the repeats, in milliseconds; sets `out`.
absl::Status Time(const Coding& coding, const PointPayload& in, int repeats, double* ms,
                  PointPayload* out) {
  double fastest = 1e9;
  for (int i = 0; i < repeats; ++i) {
    const CpuClock clock;
    auto made = coding(in);
    fastest = std::min(fastest, clock.Ms());
    if (!made.ok()) return made.status();
    *out = *std::move(made);
  }
  *ms += fastest;
  return absl::OkStatus();
}

absl::Status Measure(const Chunks& chunks, const convert::MapPointFields& fields, const char* name,
                     double rounding_m, int repeats) {
  const bool by_draco = std::string(name) == "draco";
  const Coding pack = [&](const PointPayload& raw) {
    return by_draco ? codec::PackDraco(raw, rounding_m) : codec::Quantize(raw, rounding_m);
  };
  const Coding unpack = by_draco ? codec::UnpackDraco : codec::Dequantize;
  double points = 0, bytes = 0, pack_ms = 0, unpack_ms = 0;
  uint32_t stride = 0;
  for (const std::vector<MapPoint>& chunk : chunks) {
    const PointPayload raw = convert::ToPayload(chunk, fields);
    PointPayload packed, back;
    absl::Status status = Time(pack, raw, repeats, &pack_ms, &packed);
    if (status.ok()) status = Time(unpack, packed, repeats, &unpack_ms, &back);
    if (!status.ok()) return status;
    stride = raw.stride;
    points += raw.width;
    bytes += static_cast<double>(packed.data.size());
  }
  absl::PrintF("| %s | %g mm | %d | %.2f | %.2f | %.0f | %.0f |\n", name, 1e3 * rounding_m, stride,
               bytes / points, bytes / points / stride, 1e6 * pack_ms / points,
               1e6 * unpack_ms / points);
  return absl::OkStatus();
}

absl::Status Run(const DriveOptions& drive, const std::vector<double>& roundings_m, int repeats) {
  const auto chunks = MakeMap(drive);
  if (!chunks.ok()) return chunks.status();
  size_t points = 0;
  for (const auto& chunk : *chunks) points += chunk.size();
  absl::PrintF(
      "%s, seed %d: %d points\n| encoding | rounding | raw: bytes per point | packed | share | "
      "packing: ms per million points | reading |\n|---|---|---|---|---|---|---|\n",
      drive.world, drive.seed, points);
  for (const convert::MapPointFields& fields :
       {convert::MapPointFields{false, false, false}, convert::MapPointFields{true, true, false},
        convert::MapPointFields{true, true, true}}) {
    for (const double rounding_m : roundings_m) {
      for (const char* name : {"quantized", "draco"}) {
        auto status = Measure(*chunks, fields, name, rounding_m, repeats);
        if (!status.ok()) return status;
      }
    }
  }
  return absl::OkStatus();
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) {
  CLI::App app("Sizes and times of the encodings of a simulated map's points");
  isthmus::bench::DriveOptions drive;
  std::vector<double> roundings_m = {0.001, 0.01};
  int repeats = 3;
  app.add_option("--world", drive.world, "As simulate --world")->capture_default_str();
  app.add_option("--seed", drive.seed)->capture_default_str();
  app.add_option("--seconds", drive.seconds, "Length of drives")->capture_default_str();
  app.add_option("--robots", drive.robots)->capture_default_str();
  app.add_option("--sensor", drive.sensor)->capture_default_str();
  app.add_option("--roundings", roundings_m, "Steps, metres")->capture_default_str();
  app.add_option("--repeats", repeats, "The fastest counts")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = isthmus::bench::Run(drive, roundings_m, repeats);
  if (!status.ok()) absl::FPrintF(stderr, "%s\n", status.message());
  return status.ok() ? 0 : 1;
}
