#include "client/offline/rebuild_map.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/strip.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "client/offline/carry_over.h"
#include "core/io/folder.h"
#include "server/pipeline.h"
#include "storage/archive/scan_reader.h"

namespace isthmus::cli {
namespace {

namespace fs = std::filesystem;
using storage::MapStore;

// One session on its way from the old folder to the new, with all its segments.
struct Work {
  SessionRecord record;                        // The first segment's.
  std::vector<SessionRecord> segments;         // The later ones, of the old map.
  std::unique_ptr<storage::ScanReader> scans;  // Null: there are none.
  RebuiltSession result;
};

absl::Status CheckFolders(const RebuildOptions& options) {
  std::error_code error;
  if (!fs::is_regular_file(options.from + "/isthmus.db", error)) {
    return absl::NotFoundError(absl::StrCat("there is no map in ", options.from));
  }
  if (fs::exists(options.to, error) &&
      !(fs::is_directory(options.to, error) && fs::is_empty(options.to, error))) {
    return absl::AlreadyExistsError(
        absl::StrCat(options.to, " is not empty: give a new folder with --to"));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<Work>> ListWork(const RebuildOptions& options, const MapStore& old) {
  absl::StatusOr<std::vector<SessionRecord>> records = old.ListSessions();
  if (!records.ok()) return records.status();
  std::set<SessionId> wanted(options.sessions.begin(), options.sessions.end());
  std::vector<Work> work;
  for (SessionRecord& record : *records) {
    if (record.segment > 1) {  // Comes after its first.
      const auto first = std::find_if(work.begin(), work.end(), [&](const Work& one) {
        return one.record.id == record.first_segment;
      });
      if (first != work.end()) first->segments.push_back(std::move(record));
      continue;
    }
    if (!options.sessions.empty() && wanted.erase(record.id) == 0) continue;
    Work one;
    one.result.id = record.id;
    auto scans = storage::ScanReader::Open(options.from, record.id);
    if (!scans.ok() && !absl::IsNotFound(scans.status())) return scans.status();
    if (scans.ok()) one.scans = *std::move(scans);
    one.result.is_copied = one.scans == nullptr;
    if (one.scans != nullptr) one.result.scans = one.scans->scans();
    one.record = std::move(record);
    work.push_back(std::move(one));
  }
  if (wanted.empty()) return work;
  return absl::NotFoundError(absl::StrCat(
      "there is no session \"", wanted.begin()->value(), "\" in ", options.from,
      "; segments are computed with their session: give the session that the robot opened"));
}

// Sessions that are to be made begin as active ones without scans, which is where the pipeline
// takes them up; the others come as they are.
absl::Status Prepare(const std::vector<Work>& work, const MapStore& old, MapStore& made) {
  for (const Work& one : work) {
    storage::WriteBatch batch;
    batch.sessions.push_back(one.record);
    if (one.scans != nullptr) {
      batch.sessions[0].state = SessionState::kActive;
      batch.sessions[0].finished_ns = 0;
    }
    if (one.scans == nullptr) {
      batch.sessions.insert(batch.sessions.end(), one.segments.begin(), one.segments.end());
    }
    absl::Status status = made.Write(batch);
    if (one.scans == nullptr) {
      for (const SessionRecord& record : batch.sessions) {
        if (status.ok()) status = CopySession(record.id, old, made);
      }
    }
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

// Sequences of a session count without gaps. What is missing is sent as a scan without points,
// which counts as one that the sensor could not make: where the robot was then is not known.
absl::Status FillGap(server::Pipeline& pipeline, Work& work, uint64_t from, const ScanUpload& next,
                     int64_t last_stamp_ns) {
  const uint64_t count = next.sequence - from;
  for (uint64_t i = 0; i < count; ++i) {
    const double share = static_cast<double>(i + 1) / static_cast<double>(count + 1);
    ScanUpload empty;
    empty.sequence = from + i;
    empty.end_stamp_ns =
        last_stamp_ns +
        static_cast<int64_t>(share * static_cast<double>(next.end_stamp_ns - last_stamp_ns));
    if (absl::Status status = pipeline.sessions().SubmitScan(work.record.id, std::move(empty));
        !status.ok()) {
      return status;
    }
  }
  work.result.missing += count;
  return absl::OkStatus();
}

absl::Status Replay(server::Pipeline& pipeline, Work& work,
                    const std::function<void()>& scan_read) {
  uint64_t next_sequence = 1;
  std::optional<int64_t> last_stamp_ns;
  while (true) {
    absl::StatusOr<std::optional<ScanUpload>> scan = work.scans->Next();
    if (!scan.ok()) return scan.status();
    if (!*scan) break;
    scan_read();
    if ((*scan)->sequence < next_sequence) continue;  // Sequence 0: no session has that.
    const absl::Status filled = FillGap(pipeline, work, next_sequence, **scan,
                                        last_stamp_ns.value_or((*scan)->end_stamp_ns));
    if (!filled.ok()) return filled;
    next_sequence = (*scan)->sequence + 1;
    last_stamp_ns = (*scan)->end_stamp_ns;
    absl::Status status = pipeline.sessions().SubmitScan(work.record.id, **std::move(scan));
    if (!status.ok()) return status;
  }
  const auto finished = pipeline.sessions().Finish(work.record.id);
  if (!finished.ok()) return finished.status();
  work.result.processed = finished->scans_processed;
  return absl::OkStatus();
}

absl::Status ReplayAll(server::Pipeline& pipeline, std::vector<Work>& work,
                       const RebuildProgress& progress) {
  uint64_t done = 0, total = 0;
  for (const Work& one : work) total += one.result.scans;
  for (Work& one : work) {
    if (one.scans == nullptr) continue;
    const absl::Status status = Replay(pipeline, one, [&] { progress(++done, total); });
    if (!status.ok()) {
      return absl::Status(status.code(),
                          absl::StrCat(one.record.id.value(), ": ", status.message()));
    }
  }
  return absl::OkStatus();
}

// A scan's pose, and the number of the segment whose odom it is in.
struct SegmentPose {
  uint32_t segment = 1;
  Pose T_odom_sensor;
};

// By sequence, of the session and all its segments in the store.
absl::StatusOr<std::map<uint64_t, SegmentPose>> PosesOf(const MapStore& store,
                                                        const std::vector<SessionRecord>& records) {
  std::map<uint64_t, SegmentPose> poses;
  for (const SessionRecord& record : records) {
    const auto trajectory = store.GetTrajectory(record.id);
    if (!trajectory.ok()) return trajectory.status();
    for (const TrajectoryEntry& entry : *trajectory) {
      poses[entry.sequence] = {record.segment, entry.T_odom_sensor};
    }
  }
  return poses;
}

// Positions of the scans that both maps have, in odom. Segments that do not begin with the same
// scan are first laid on each other where both have one.
void Compare(const std::map<uint64_t, SegmentPose>& old, const std::map<uint64_t, SegmentPose>& now,
             RebuiltSession& result) {
  std::map<uint32_t, uint64_t> first_old, first_now;
  for (const auto& [sequence, pose] : old) first_old.try_emplace(pose.segment, sequence);
  for (const auto& [sequence, pose] : now) first_now.try_emplace(pose.segment, sequence);
  std::map<std::pair<uint32_t, uint32_t>, Pose> T_old_new;
  double sum = 0;
  for (const auto& [sequence, pose] : now) {
    const auto found = old.find(sequence);
    if (found == old.end()) continue;
    const SegmentPose& before = found->second;
    ++result.compared;
    const bool begin_alike = first_old[before.segment] == first_now[pose.segment];
    const Pose T = begin_alike ? Pose() : before.T_odom_sensor * pose.T_odom_sensor.Inverse();
    const Pose& laid = T_old_new.try_emplace({before.segment, pose.segment}, T).first->second;
    const double distance =
        (before.T_odom_sensor.translation() - laid * pose.T_odom_sensor.translation()).norm();
    sum += distance * distance;
    result.max_m = std::max(result.max_m, distance);
  }
  if (result.compared > 0) result.rmse_m = std::sqrt(sum / static_cast<double>(result.compared));
}

// A session and its segments, as a store has them.
std::vector<SessionRecord> RecordsOf(const std::vector<SessionRecord>& all,
                                     const SessionId& opened) {
  std::vector<SessionRecord> records;
  for (const SessionRecord& record : all) {
    if (record.opened() == opened) records.push_back(record);
  }
  return records;
}

// Adds what only the stores know: poses, and when sessions were finished.
absl::Status Conclude(const MapStore& old, MapStore& made, std::vector<Work>& work) {
  const auto all = made.ListSessions();
  if (!all.ok()) return all.status();
  for (Work& one : work) {
    const std::vector<SessionRecord> records = RecordsOf(*all, one.record.id);
    one.result.segments = static_cast<uint32_t>(records.size());
    storage::WriteBatch batch;
    for (const SessionRecord& record : records) {
      const auto submaps = made.ListSubmaps(record.id);
      if (!submaps.ok()) return submaps.status();
      one.result.submaps += static_cast<uint32_t>(submaps->size());
      SessionRecord& finished = batch.sessions.emplace_back(record);
      finished.finished_ns = one.record.finished_ns;
    }
    if (one.scans == nullptr) continue;
    std::vector<SessionRecord> before_records = one.segments;
    before_records.push_back(one.record);
    const auto before = PosesOf(old, before_records);
    if (!before.ok()) return before.status();
    const auto now = PosesOf(made, records);
    if (!now.ok()) return now.status();
    Compare(*before, *now, one.result);
    if (one.record.state == SessionState::kActive) continue;  // It was finished now.
    if (absl::Status status = made.Write(batch); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status RunPipeline(const RebuildOptions& options, const MapStore& old,
                         std::unique_ptr<MapStore> made, std::vector<Work>& work,
                         const RebuildProgress& progress, RebuildSummary& summary) {
  server::PipelineOptions settings = options.pipeline;
  settings.archive = {};
  settings.retention = {};
  auto pipeline = server::Pipeline::Open(settings, std::move(made));
  if (!pipeline.ok()) return pipeline.status();
  if (absl::Status status = ReplayAll(**pipeline, work, progress); !status.ok()) return status;
  (*pipeline)->WaitUntilIdle();
  std::vector<SessionId> sessions;
  for (const Work& one : work) {
    sessions.push_back(one.record.id);
    for (const SessionRecord& segment : one.segments) sessions.push_back(segment.id);
  }
  absl::Status status = CarryAnchors(old, sessions, **pipeline, summary);
  (*pipeline)->WaitUntilIdle();
  (*pipeline)->Shutdown();
  return status;
}

void NoteDamage(const Work& work, RebuildSummary& summary) {
  for (const std::string& damage : work.scans->damage()) summary.notes.push_back(damage);
  const auto listed = static_cast<int64_t>(work.scans->damage().size());
  if (work.scans->damaged_count() > listed) {
    summary.notes.push_back(absl::StrCat("and ", work.scans->damaged_count() - listed, " more"));
  }
}

absl::StatusOr<RebuildSummary> MakeMap(const RebuildOptions& options,
                                       const RebuildProgress& progress) {
  auto old = storage::OpenSqliteStore(options.from, options.storage);
  if (!old.ok()) return old.status();
  absl::StatusOr<std::vector<Work>> work = ListWork(options, **old);
  if (!work.ok()) return work.status();
  auto made = storage::OpenSqliteStore(options.to, options.storage);
  if (!made.ok()) return made.status();
  RebuildSummary summary;
  absl::Status status = Prepare(*work, **old, **made);
  if (status.ok()) status = CarryManualDecisions(**old, **made, summary);
  if (status.ok()) {
    status = RunPipeline(options, **old, *std::move(made), *work, progress, summary);
  }
  if (!status.ok()) return status;
  made = storage::OpenSqliteStore(options.to, options.storage);
  if (!made.ok()) return made.status();
  if (status = Conclude(**old, **made, *work); !status.ok()) return status;
  if (status = CarrySegmentManualDecisions(**old, **made, summary); !status.ok()) return status;
  for (const Work& one : *work) {
    summary.sessions.push_back(one.result);
    if (one.scans == nullptr) continue;
    NoteDamage(one, summary);
    if (!options.with_scans) continue;
    status = CopyScans(options.from, options.to, one.record.id);
    if (!status.ok()) return status;
  }
  return summary;
}

}  // namespace

absl::StatusOr<RebuildSummary> RebuildMap(const RebuildOptions& options,
                                          const RebuildProgress& progress) {
  if (absl::Status status = CheckFolders(options); !status.ok()) return status;
  absl::string_view target = options.to;
  while (absl::ConsumeSuffix(&target, "/")) {
  }
  RebuildOptions in_part = options;
  in_part.to = absl::StrCat(target, ".part");
  std::error_code error;
  fs::remove_all(in_part.to, error);  // Left by a program that died.
  if (error) return io::FileError("remove", in_part.to, error.value());
  io::PartFolder part(in_part.to);
  absl::StatusOr<RebuildSummary> summary = MakeMap(in_part, progress);
  if (!summary.ok()) return summary;
  if (absl::Status status = part.Become(std::string(target)); !status.ok()) return status;
  return summary;
}

}  // namespace isthmus::cli
