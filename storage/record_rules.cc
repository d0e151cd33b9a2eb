#include "storage/record_rules.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

namespace isthmus::storage {
namespace {

// Only the upper triangle is stored; an asymmetry left by products of matrices is no matter.
bool IsSymmetric(const Matrix6d& matrix) {
  constexpr double kRounding = 1e-6;
  const double largest = matrix.cwiseAbs().maxCoeff();
  return matrix.allFinite() &&
         (matrix - matrix.transpose()).cwiseAbs().maxCoeff() <= kRounding * largest;
}

absl::Status CheckEdges(const std::string& name, const std::vector<SubmapEdge>& edges) {
  for (const SubmapEdge& edge : edges) {
    if (!edge.T_a_b.IsFinite() || !edge.information.allFinite()) {
      return absl::InvalidArgumentError(absl::StrCat(name, " has an edge with NaN or Inf"));
    }
    if (!IsSymmetric(edge.information)) {
      return absl::InvalidArgumentError(
          absl::StrCat(name, " has an edge whose information is not symmetric"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckPoints(const Submap& submap) {
  for (const SubmapPoint& point : submap.points) {
    // NaN is not near.
    const bool near = std::abs(point.x) <= kMaxCoordinateM &&
                      std::abs(point.y) <= kMaxCoordinateM && std::abs(point.z) <= kMaxCoordinateM;
    if (point.keyframe >= submap.keyframes.size() || !near) {
      return absl::InvalidArgumentError(absl::StrCat(
          "submap ", ToString(submap.id), " has a point that is not finite, farther than ",
          kMaxCoordinateM, " m from its origin, or of a keyframe it does not have"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckMove(const SubmapMove& move, const std::map<SessionId, SessionId>& frames) {
  const std::string name = absl::StrCat("the move of submap ", ToString(move.submap));
  if (!move.before && !move.after) {
    return absl::InvalidArgumentError(absl::StrCat(name, " goes from nowhere to nowhere"));
  }
  if ((move.before && !move.before->IsFinite()) || (move.after && !move.after->IsFinite())) {
    return absl::InvalidArgumentError(absl::StrCat(name, " has NaN or Inf"));
  }
  if (move.before.has_value() == move.frame_before.empty() ||
      move.after.has_value() == move.frame_after.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, " must name a frame where it has a pose, and only there"));
  }
  if (!move.after) return absl::OkStatus();
  const auto frame = frames.find(move.submap.session);
  if (frame != frames.end() && frame->second == move.frame_after) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(name, " is to the frame of ", move.frame_after.value(),
                   ", which is not where the revision places its session"));
}

}  // namespace

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
  if (!IsSymmetric(submap.drift_covariance) || submap.drift_covariance.diagonal().minCoeff() < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("submap ", name, " has a drift covariance that is not a covariance"));
  }
  if (submap.points.size() > kMaxSubmapPoints) {
    return absl::InvalidArgumentError(absl::StrCat("submap ", name, " has ", submap.points.size(),
                                                   " points; the limit is ", kMaxSubmapPoints,
                                                   ": cut it into several"));
  }
  return CheckPoints(submap);
}

absl::Status CheckMatchEdges(const Match& match) {
  const std::string name = absl::StrCat("match ", match.a.value(), " ~ ", match.b.value());
  for (const RivalMatch& rival : match.rivals) {
    if (!rival.T_a_b.IsFinite()) {
      return absl::InvalidArgumentError(absl::StrCat(name, " has a rival with NaN or Inf"));
    }
    if (absl::Status status = CheckEdges(name, rival.edges); !status.ok()) return status;
  }
  return CheckEdges(name, match.edges);
}

absl::Status CheckLoop(const LoopClosure& loop) {
  const std::string name =
      absl::StrCat("loop closure ", loop.id, " of session ", loop.session.value());
  if (loop.id == 0) return absl::InvalidArgumentError(absl::StrCat(name, ": ids count from 1"));
  if (!loop.T_a_b.IsFinite()) {
    return absl::InvalidArgumentError(absl::StrCat(name, " has a pose with NaN or Inf"));
  }
  bool own_pair = false;
  for (const SubmapEdge& edge : loop.edges) {
    if (edge.submap_a >= edge.submap_b) {
      return absl::InvalidArgumentError(absl::StrCat(name, " has an edge from submap ",
                                                     edge.submap_a, " to ", edge.submap_b,
                                                     ": edges go from older to newer ones"));
    }
    own_pair = own_pair || (edge.submap_a == loop.submap_a && edge.submap_b == loop.submap_b);
  }
  if (!own_pair) {
    return absl::InvalidArgumentError(absl::StrCat(name, " has no edge between its own submaps ",
                                                   loop.submap_a, " and ", loop.submap_b));
  }
  return CheckEdges(name, loop.edges);
}

absl::Status CheckAnchor(const Anchor& anchor) {
  const std::string name = absl::StrCat("the anchor of submap ", ToString(anchor.submap));
  double largest = 0;
  for (const double sigma : {anchor.sigma_xy_m, anchor.sigma_z_m, anchor.sigma_deg}) {
    if (!std::isfinite(sigma) || sigma < 0) {
      return absl::InvalidArgumentError(
          absl::StrCat(name, " has a sigma of ", sigma, "; it must be positive, or 0: not known"));
    }
    largest = std::max(largest, sigma);
  }
  if (largest == 0) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, " says nothing: at least one sigma must be positive"));
  }
  if (!anchor.T_map_submap.IsFinite()) {
    return absl::InvalidArgumentError(absl::StrCat(name, " has a pose with NaN or Inf"));
  }
  const Eigen::Vector3d at = anchor.T_map_submap.translation().cwiseAbs();
  if ((anchor.sigma_xy_m > 0 && at.head<2>().maxCoeff() > kMaxAnchorM) ||
      (anchor.sigma_z_m > 0 && at.z() > kMaxAnchorM)) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, " is farther than ", kMaxAnchorM,
                     " m from the origin: give it in a frame that begins nearer"));
  }
  return absl::OkStatus();
}

absl::Status CheckRevision(const MapRevision& revision, const std::vector<SubmapMove>& moves) {
  std::map<SessionId, SessionId> frames;
  for (const Placement& placement : revision.placements) {
    const std::string name = absl::StrCat("the placement of session ", placement.session.value());
    if (!placement.T_map_odom.IsFinite()) {
      return absl::InvalidArgumentError(absl::StrCat(name, " has NaN or Inf"));
    }
    if (!frames.emplace(placement.session, placement.reference).second) {
      return absl::InvalidArgumentError(absl::StrCat(name, " comes twice"));
    }
  }
  std::set<SubmapId> moved;
  for (const SubmapMove& move : moves) {
    if (absl::Status status = CheckMove(move, frames); !status.ok()) return status;
    if (!moved.insert(move.submap).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("submap ", ToString(move.submap), " moves twice in one revision"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckEvents(const std::vector<Event>& events) {
  for (const Event& event : events) {
    if (event.kind == EventKind::kUnknown) {
      return absl::InvalidArgumentError("an event of no kind");
    }
    for (const std::string* text :
         {&event.text, &event.actor.who, &event.actor.from, &event.actor.request_id,
          &event.robot.value(), &event.session.value()}) {
      if (text->size() <= kMaxEventText) continue;
      return absl::InvalidArgumentError(absl::StrCat("an event with a text of ", text->size(),
                                                     " bytes; ", kMaxEventText, " may be kept"));
    }
  }
  return absl::OkStatus();
}

}  // namespace isthmus::storage
