#include "client/offline/carry_over.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "core/io/file_io.h"
#include "storage/archive/scan_segment.h"

namespace isthmus::cli {
namespace {

namespace fs = std::filesystem;
using storage::MapStore;

const SubmapInfo* Find(const std::vector<SubmapInfo>& submaps, uint32_t index) {
  const auto found = std::find_if(submaps.begin(), submaps.end(), [&](const SubmapInfo& submap) {
    return submap.id.index == index;
  });
  return found == submaps.end() ? nullptr : &*found;
}

const SubmapInfo* Nearest(const std::vector<SubmapInfo>& submaps, int64_t first_stamp_ns) {
  const auto away = [&](const SubmapInfo& submap) {
    return std::abs(submap.first_stamp_ns - first_stamp_ns);
  };
  const auto found =
      std::min_element(submaps.begin(), submaps.end(),
                       [&](const SubmapInfo& a, const SubmapInfo& b) { return away(a) < away(b); });
  return found == submaps.end() ? nullptr : &*found;
}

// The pipeline lists a robot's submaps; by session here.
absl::StatusOr<std::map<SessionId, std::vector<SubmapInfo>>> MadeSubmaps(
    server::Pipeline& pipeline) {
  const auto listed = pipeline.reader().ListSubmaps(std::nullopt);
  if (!listed.ok()) return listed.status();
  std::map<SessionId, std::vector<SubmapInfo>> submaps;
  for (const SubmapStatus& submap : *listed) {
    submaps[submap.info.id.session].push_back(submap.info);
  }
  return submaps;
}

// True if the two are in one frame: that of the first scan of a segment. A session that the robot
// opened begins with its first.
bool BeginAlike(const SessionRecord& record, const std::vector<SubmapInfo>& old,
                const std::vector<SubmapInfo>& made) {
  if (record.segment == 1) return true;
  const SubmapInfo* before = Find(old, 0);
  const SubmapInfo* now = Find(made, 0);
  return before != nullptr && now != nullptr && before->first_sequence == now->first_sequence;
}

// The anchor where the new map has it; absent where there is nothing to hang it on.
absl::StatusOr<std::optional<Anchor>> Moved(const Anchor& anchor, const MapStore& old,
                                            const std::vector<SubmapInfo>& made) {
  const auto before = old.ListSubmaps(anchor.submap.session);
  if (!before.ok()) return before.status();
  const auto record = old.GetSession(anchor.submap.session);
  if (!record.ok()) return record.status();
  const SubmapInfo* from = Find(*before, anchor.submap.index);
  if (from == nullptr || !BeginAlike(*record, *before, made)) return std::optional<Anchor>();
  const SubmapInfo* to = Nearest(made, from->first_stamp_ns);
  if (to == nullptr) return std::optional<Anchor>();
  Anchor moved = anchor;
  moved.submap = to->id;
  moved.T_map_submap = anchor.T_map_submap * from->T_odom_submap.Inverse() * to->T_odom_submap;
  return std::optional<Anchor>(std::move(moved));
}

absl::Status NoteRejectedLoops(const MapStore& old, const std::set<SessionId>& sessions,
                               RebuildSummary& summary) {
  const auto loops = old.ListLoops();
  if (!loops.ok()) return loops.status();
  const auto rejected = std::count_if(loops->begin(), loops->end(), [&](const LoopClosure& loop) {
    return loop.rejected && sessions.contains(loop.session);
  });
  if (rejected > 0) {
    summary.notes.push_back(absl::StrCat(rejected,
                                         " loop closures rejected by hand are not carried over: "
                                         "check those of the new map with isthmus loops"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CopySession(const SessionId& session, const MapStore& old, MapStore& made) {
  const auto submaps = old.ListSubmaps(session);
  if (!submaps.ok()) return submaps.status();
  const auto trajectory = old.GetTrajectory(session);
  if (!trajectory.ok()) return trajectory.status();
  std::map<uint32_t, std::vector<TrajectoryEntry>> poses;
  for (const TrajectoryEntry& entry : *trajectory) poses[entry.submap_index].push_back(entry);
  for (const SubmapInfo& info : *submaps) {
    auto submap = old.GetSubmap(info.id);
    if (!submap.ok()) return submap.status();
    storage::WriteBatch batch;
    batch.submaps.push_back(*std::move(submap));
    for (const TrajectoryEntry& entry : poses[info.id.index]) {
      batch.trajectory.emplace_back(session, entry);
    }
    if (absl::Status status = made.Write(batch); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status CarryManualDecisions(const MapStore& old, MapStore& made, RebuildSummary& summary) {
  const auto manual_decisions = old.ListManualDecisions();
  if (!manual_decisions.ok()) return manual_decisions.status();
  storage::WriteBatch batch;
  for (const ManualDecision& manual_decision : *manual_decisions) {
    if (!made.GetSession(manual_decision.a).ok() || !made.GetSession(manual_decision.b).ok())
      continue;
    batch.manual_decisions.push_back(manual_decision);
  }
  summary.manual_decisions = batch.manual_decisions.size();
  return made.Write(batch);
}

absl::Status CarrySegmentManualDecisions(const MapStore& old, MapStore& made,
                                         RebuildSummary& summary) {
  const auto manual_decisions = old.ListManualDecisions();
  if (!manual_decisions.ok()) return manual_decisions.status();
  const auto carried = made.ListManualDecisions();
  if (!carried.ok()) return carried.status();
  const auto is_same_frame = [&](const SessionId& session) {
    const auto record = old.GetSession(session);
    const auto before = old.ListSubmaps(session), now = made.ListSubmaps(session);
    return record.ok() && before.ok() && now.ok() && BeginAlike(*record, *before, *now);
  };
  storage::WriteBatch batch;
  uint64_t left_out = 0;
  for (const ManualDecision& manual_decision : *manual_decisions) {
    const bool is_there =
        std::any_of(carried->begin(), carried->end(), [&](const ManualDecision& other) {
          return other.a == manual_decision.a && other.b == manual_decision.b;
        });
    const auto a = old.GetSession(manual_decision.a), b = old.GetSession(manual_decision.b);
    const bool is_wanted =
        a.ok() && b.ok() && made.GetSession(a->opened()).ok() && made.GetSession(b->opened()).ok();
    if (is_there || !is_wanted) continue;
    if (is_same_frame(manual_decision.a) && is_same_frame(manual_decision.b)) {
      batch.manual_decisions.push_back(manual_decision);
    } else {
      ++left_out;
    }
  }
  summary.manual_decisions += batch.manual_decisions.size();
  if (left_out > 0) {
    summary.notes.push_back(absl::StrCat(
        left_out, " manual decisions are not carried over: their segments begin elsewhere now"));
  }
  return made.Write(batch);
}

absl::Status CarryAnchors(const MapStore& old, const std::vector<SessionId>& sessions,
                          server::Pipeline& pipeline, RebuildSummary& summary) {
  const std::set<SessionId> wanted(sessions.begin(), sessions.end());
  const auto anchors = old.ListAnchors();
  if (!anchors.ok()) return anchors.status();
  const auto made = MadeSubmaps(pipeline);
  if (!made.ok()) return made.status();
  for (const Anchor& anchor : *anchors) {
    if (!wanted.contains(anchor.submap.session)) continue;
    const auto submaps = made->find(anchor.submap.session);
    auto moved =
        Moved(anchor, old, submaps == made->end() ? std::vector<SubmapInfo>() : submaps->second);
    if (!moved.ok()) return moved.status();
    if (!*moved) {
      summary.notes.push_back(absl::StrCat("the anchor of submap ", ToString(anchor.submap),
                                           " is not carried over: its session has no submaps now, "
                                           "or is in another frame"));
      continue;
    }
    const auto revision = pipeline.decisions().PutAnchor(**std::move(moved));
    if (!revision.ok()) return revision.status();
    ++summary.anchors;
  }
  const auto datum = old.GetDatum();
  if (!datum.ok()) return datum.status();
  if (*datum) {
    if (absl::Status status = pipeline.decisions().SetDatum(**datum); !status.ok()) return status;
  }
  return NoteRejectedLoops(old, wanted, summary);
}

absl::Status CopyScans(const std::string& from, const std::string& to, const SessionId& session) {
  const std::string source = absl::StrCat(from, "/scans/", session.value());
  const std::string target = absl::StrCat(to, "/scans/", session.value());
  std::error_code error;
  fs::create_directories(target, error);
  const std::vector<int> segments = storage::ListSegments(source);
  for (const int number : segments) {
    const std::string name = storage::SegmentName(number);
    const fs::path path = source + "/" + name, copy = target + "/" + name;
    std::error_code not_linked = std::make_error_code(std::errc::not_supported);
    if (number != segments.back()) fs::create_hard_link(path, copy, not_linked);
    if (not_linked) fs::copy_file(path, copy, error);
    if (error) return io::FileError("copy scans to", copy.string(), error.value());
  }
  return absl::OkStatus();
}

}  // namespace isthmus::cli
