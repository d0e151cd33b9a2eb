#include "storage/batch_rules.h"

#include <absl/strings/str_cat.h>

#include <cmath>
#include <set>

namespace isthmus::storage {
namespace {

absl::Status CheckSubmap(const Submap& submap) {
  const std::string name = ToString(submap.id);
  if (submap.keyframes.empty() || submap.keyframes.size() > 65535) {
    return absl::InvalidArgumentError(absl::StrCat(
        "submap ", name, " has ", submap.keyframes.size(), " keyframes; it needs 1 to 65535"));
  }
  bool finite = submap.T_odom_submap.IsFinite();
  for (const Keyframe& keyframe : submap.keyframes) {
    finite = finite && keyframe.T_submap_sensor.IsFinite();
  }
  if (!finite) {
    return absl::InvalidArgumentError(absl::StrCat("submap ", name, " has a pose with NaN or Inf"));
  }
  if (submap.points.size() > kMaxSubmapPoints) {
    return absl::InvalidArgumentError(absl::StrCat("submap ", name, " has ", submap.points.size(),
                                                   " points; the limit is ", kMaxSubmapPoints,
                                                   ": cut it into several"));
  }
  for (const SubmapPoint& point : submap.points) {
    // NaN is not near.
    const bool near = std::abs(point.x) <= kMaxCoordinateM &&
                      std::abs(point.y) <= kMaxCoordinateM && std::abs(point.z) <= kMaxCoordinateM;
    if (point.keyframe >= submap.keyframes.size() || !near) {
      return absl::InvalidArgumentError(
          absl::StrCat("submap ", name, " has a point that is not finite, farther than ",
                       kMaxCoordinateM, " m from its origin, or of a keyframe it does not have"));
    }
  }
  return absl::OkStatus();
}

// Of a match, or of a verdict on one.
template <typename Record>
absl::Status CheckPair(const Record& match,
                       const std::function<bool(const SessionId&)>& has_session) {
  if (!(match.a < match.b) || !match.T_a_b.IsFinite()) {
    return absl::InvalidArgumentError(
        absl::StrCat("match ", match.a.value(), " ~ ", match.b.value(),
                     ": the pair must be ordered and its transform finite"));
  }
  for (const SessionId& session : {match.a, match.b}) {
    if (!has_session(session)) {
      return absl::FailedPreconditionError(
          absl::StrCat("match with session ", session.value(), ", which does not exist"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckEdges(const Match& match) {
  for (const SubmapEdge& edge : match.edges) {
    if (edge.T_a_b.IsFinite() && edge.information.allFinite()) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        "match ", match.a.value(), " ~ ", match.b.value(), " has an edge with NaN or Inf"));
  }
  return absl::OkStatus();
}

absl::Status CheckRevision(const MapRevision& revision, int64_t latest) {
  if (revision.revision <= latest) {
    return absl::FailedPreconditionError(
        absl::StrCat("revision ", revision.revision, " is not newer than the latest, ", latest));
  }
  for (const Placement& placement : revision.placements) {
    if (!placement.T_map_odom.IsFinite()) {
      return absl::InvalidArgumentError(
          absl::StrCat("the placement of session ", placement.session.value(), " has NaN or Inf"));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckBatch(const WriteBatch& batch, const StoreContents& contents) {
  std::set<SessionId> inserted;
  for (const SessionRecord& record : batch.sessions) {
    if (record.id.empty()) return absl::InvalidArgumentError("a session without an id");
    inserted.insert(record.id);
  }
  const auto has_session = [&](const SessionId& id) {
    return inserted.count(id) > 0 || contents.has_session(id);
  };
  const SessionId* last_known = nullptr;  // A batch mostly holds scans of one session.
  for (const auto& [session, entry] : batch.trajectory) {
    if (last_known != nullptr && *last_known == session) continue;
    if (!has_session(session)) {
      return absl::FailedPreconditionError(
          absl::StrCat("a pose of session ", session.value(), ", which does not exist"));
    }
    last_known = &session;
  }
  std::set<SubmapId> submaps;
  for (const auto& submap : batch.submaps) {
    if (!has_session(submap->id.session)) {
      return absl::FailedPreconditionError(
          absl::StrCat("submap ", ToString(submap->id), " of a session that does not exist"));
    }
    if (!submaps.insert(submap->id).second || contents.has_submap(submap->id)) {
      return absl::AlreadyExistsError(
          absl::StrCat("submap ", ToString(submap->id), " is stored already"));
    }
    if (absl::Status status = CheckSubmap(*submap); !status.ok()) return status;
  }
  for (const Match& match : batch.matches) {
    if (absl::Status status = CheckPair(match, has_session); !status.ok()) return status;
    if (absl::Status status = CheckEdges(match); !status.ok()) return status;
  }
  for (const Verdict& verdict : batch.verdicts) {
    if (absl::Status status = CheckPair(verdict, has_session); !status.ok()) return status;
  }
  return batch.revision ? CheckRevision(*batch.revision, contents.latest_revision)
                        : absl::OkStatus();
}

absl::Status UnknownSession(const SessionId& session) {
  return absl::NotFoundError(absl::StrCat("there is no session '", session.value(), "'"));
}

absl::Status UnknownSubmap(const SubmapId& submap) {
  return absl::NotFoundError(absl::StrCat("there is no submap '", ToString(submap), "'"));
}

absl::Status NoFeatures(const SubmapId& submap, const std::string& kind) {
  return absl::NotFoundError(
      absl::StrCat("no features of kind '", kind, "' are kept for submap ", ToString(submap)));
}

}  // namespace isthmus::storage
