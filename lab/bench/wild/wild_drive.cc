#include "lab/bench/wild/wild_drive.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <system_error>
#include <utility>

#include "core/io/file_io.h"
#include "lab/bench/wild/scan_file.h"

namespace isthmus::bench {
namespace {

using simulation::DrawWildDrive;
using simulation::Simulator;
using simulation::WildDrive;
using simulation::WildOptions;

WildRide Lazily(uint64_t seed, WildDrive drawn) {
  WildRide ride{drawn.kind, drawn.carrier, drawn.about, seed, {}};
  const std::shared_ptr<const Simulator> simulator = std::move(drawn.simulator);
  ride.drive.sensor = simulator->lidar().name;
  for (int turn = 0; turn < simulator->scan_count(); ++turn) {
    ride.drive.shots.push_back({turn, simulator->Stamp(0, turn)});
  }
  ride.drive.scan_of = [simulator](int turn) { return simulator->MakeScan(0, turn); };
  ride.drive.truth_of = [simulator](int turn) { return simulator->Truth(0, turn).pose; };
  return ride;
}

std::string TitleOf(const WildRide& ride) {
  return absl::StrCat(ride.kind, "\n", ride.carrier, "\n", ride.about, "\n", ride.drive.sensor);
}

absl::StatusOr<WildRide> FromFile(uint64_t seed, const std::string& path) {
  auto file = ScanFile::Open(path);
  if (!file.ok()) return file.status();
  const std::vector<std::string> title = absl::StrSplit((*file)->title(), '\n');
  if (title.size() != 4) return absl::DataLossError(path + " is not a wild drive; remove it");
  WildRide ride{title[0], title[1], title[2], seed, {}};
  ride.drive.sensor = title[3];
  for (int turn = 0; turn < (*file)->scans(); ++turn) {
    ride.drive.shots.push_back({turn, (*file)->end_stamp_ns(turn)});
  }
  ride.drive.scan_of = [file = *file](int turn) {
    auto scan = file->Read(turn);
    if (scan.ok()) return *std::move(scan);
    std::cerr << "odometry_benchmark: " << scan.status().message() << std::endl;
    std::exit(1);  // The caller takes scans, not errors.
  };
  ride.drive.truth_of = [file = *file](int turn) { return file->Truth(turn); };
  return ride;
}

std::string PathOf(uint64_t seed, const WildOptions& chosen, const std::string& cache) {
  return absl::StrCat(cache, "/", chosen.kind, "-", seed, "-", chosen.sensor, "-", chosen.seconds,
                      "s-v", simulation::kWildVersion, ".wild");
}

}  // namespace

absl::StatusOr<WildRide> GetWildRide(uint64_t seed, const WildOptions& options,
                                     const std::string& cache) {
  const auto chosen = simulation::ChooseWild(seed, options);
  if (!chosen.ok()) return chosen.status();
  const std::string path = PathOf(seed, *chosen, cache);
  if (!cache.empty() && std::filesystem::exists(path)) return FromFile(seed, path);
  auto drawn = DrawWildDrive(seed, options);
  if (!drawn.ok()) return drawn.status();
  WildRide ride = Lazily(seed, *std::move(drawn));
  if (cache.empty()) return ride;
  std::error_code error;
  std::filesystem::create_directories(cache, error);
  if (error) return io::FileError("make", cache, error.value());
  ScanFileWriter writer(path, TitleOf(ride));
  for (size_t turn = 0; turn < ride.drive.shots.size(); ++turn) {
    const auto index = static_cast<int>(turn);
    const auto status = writer.Add(ride.drive.scan_of(index), ride.drive.truth_of(index));
    if (!status.ok()) return status;
  }
  if (auto status = writer.Finish(); !status.ok()) return status;
  return FromFile(seed, path);
}

}  // namespace isthmus::bench
