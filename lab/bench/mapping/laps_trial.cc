#include "lab/bench/mapping/laps_trial.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include "client/evaluation/trajectory_error.h"
#include "core/stopwatch.h"
#include "lab/bench/cpu_clock.h"
#include "lab/bench/mapping/upload.h"
#include "lab/bench/memory.h"
#include "lab/bench/merging/temporary_folder.h"
#include "server/pipeline.h"
#include "storage/sqlite/sqlite_store.h"

namespace isthmus::bench {
namespace {

double FolderMb(const std::string& folder) {
  double bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::error_code error;
    const auto size = entry.file_size(error);
    if (!error) bytes += static_cast<double>(size);
  }
  return bytes / 1e6;
}

// Submaps by their index in place of time.
absl::StatusOr<double> SubmapRmse(const std::vector<SubmapStatus>& submaps,
                                  const LapReplay& replay) {
  constexpr int64_t kSecond = 1'000'000'000;
  evaluation::TrajectoryPair pair;
  for (const SubmapStatus& submap : submaps) {
    if (!submap.component) continue;
    const int64_t stamp = kSecond * submap.info.id.index;
    pair.truth.push_back({stamp, replay.TruePose(submap.info.id.index)});
    pair.estimate.push_back({stamp, submap.T_map_submap});
  }
  const auto errors = evaluation::CompareTrajectories({pair});
  if (!errors.ok()) return errors.status();
  return errors->all.rmse_m;
}

absl::Status Measure(const LapReplay& replay, const std::string& folder, server::Pipeline& pipeline,
                     LapsRow* row) {
  const auto submaps = pipeline.reader().ListSubmaps(std::nullopt);
  if (!submaps.ok()) return submaps.status();
  const auto loops = pipeline.reader().ListLoops(std::nullopt);
  if (!loops.ok()) return loops.status();
  const auto rmse = SubmapRmse(*submaps, replay);
  if (!rmse.ok()) return rmse.status();
  const MapInfo info = pipeline.GetMapInfo();
  row->submaps = info.submaps;
  row->retired = info.retired;
  row->loops = loops->size();
  for (const Loop& loop : *loops) row->edges += loop.loop.edges.size();
  row->database_mb = FolderMb(folder);
  row->resident_mb = ResidentMb();
  row->rmse_m = *rmse;
  return absl::OkStatus();
}

double LengthOf(const LapReplay& replay) {
  double length = 0;
  for (uint32_t i = 0; i < replay.submaps(); ++i) {
    length += (replay.TruePose(i + 1).translation() - replay.TruePose(i).translation()).norm();
  }
  return length;
}

}  // namespace

absl::StatusOr<LapsTrial> RunLaps(LapReplay replay, int laps, int every,
                                  const server::PipelineOptions& options,
                                  const std::function<void(const LapsRow&)>& progress) {
  const TemporaryFolder folder;
  auto store = storage::OpenSqliteStore(folder.path(), {.sync_every_commit = false});
  if (!store.ok()) return store.status();
  const auto pipeline = server::Pipeline::Open(options, *std::move(store));
  if (!pipeline.ok()) return pipeline.status();
  const auto session = (*pipeline)->sessions().Create({RobotId("robot"), "vlp16"});
  if (!session.ok()) return session.status();
  LapsTrial trial = {replay.submaps(), LengthOf(replay), {}};
  double ms = 0, cpu_ms = 0;
  for (int lap = 1; lap <= laps; ++lap) {
    for (size_t i = 0; i < replay.submaps(); ++i) {
      Submap submap = replay.Next();
      submap.id.session = session->record.id;
      submap.robot = session->record.robot;
      const Stopwatch stopwatch;
      const CpuClock clock(CpuClock::Of::kProcess);
      if (absl::Status status = Upload(submap, **pipeline); !status.ok()) return status;
      ms += stopwatch.Ms();
      cpu_ms += clock.Ms();
    }
    if (lap % every != 0 && lap != laps) continue;
    const int since = trial.rows.empty() ? lap : lap - trial.rows.back().laps;
    LapsRow& row = trial.rows.emplace_back();
    row.laps = lap;
    row.ms_per_lap = std::exchange(ms, 0) / since;
    row.cpu_ms_per_lap = std::exchange(cpu_ms, 0) / since;
    absl::Status status = Measure(replay, folder.path(), **pipeline, &row);
    if (!status.ok()) return status;
    if (progress) progress(row);
  }
  return trial;
}

}  // namespace isthmus::bench
