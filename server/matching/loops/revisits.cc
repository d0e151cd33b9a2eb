#include "server/matching/loops/revisits.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "server/matching/loops/limits.h"
#include "server/matching/prepared/visibility.h"

namespace isthmus::matching {
namespace {

constexpr double kNsPerHour = 3600e9;  // Math.

std::vector<Eigen::Vector3f> Sample(const PreparedSubmap& submap) {
  std::vector<Eigen::Vector3f> points;
  const size_t stride = submap.surface().size() / kRevisitPoints + 1;
  for (size_t i = 0; i < submap.surface().size(); i += stride) {
    points.push_back(submap.surface()[i].position);
  }
  return points;
}

// The counts that are kept of a submap.
struct Counted {
  int64_t last_stamp_ns = 0;
  bool is_readable = true;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius_m = 0;
  std::vector<Eigen::Vector3f> points;
  std::vector<uint8_t> looks;  // Looks at each point; not above the limit.
  RobotId last_look = {};      // The robot of the last look that was counted.
  // Time of the last look by another session, at the latest; long ago if there was none.
  int64_t looked_ns = std::numeric_limits<int64_t>::min() / 2;
  std::optional<int64_t> due_ns = {};  // The same, when it was seen often enough.
};

// In the order in which they end.
using Order = std::tuple<int64_t, SubmapId>;

}  // namespace

struct RevisitCounter::State {
  State(const RevisitOptions& revisit_options, PreparedReader reader)
      : options(revisit_options), read(std::move(reader)) {
    options.min_looks = std::clamp(options.min_looks, 1, 255);
  }

  // With a session that is gone all that it looked at: that is counted anew, without its looks.
  void Forget(const std::map<SubmapId, const PlacedSubmap*>& placed) {
    std::set<SessionId> sessions;
    for (const auto& [id, one] : placed) sessions.insert(id.session);
    const bool is_deleted = std::any_of(counted.begin(), counted.end(), [&](const auto& entry) {
      return !sessions.contains(entry.first.session);
    });
    if (is_deleted) counted.clear();
    std::erase_if(counted, [&](const auto& entry) { return placed.count(entry.first) == 0; });
  }

  // The placed submaps that are not counted yet, the first few to end.
  std::vector<const PlacedSubmap*> TakeNew(const std::vector<PlacedSubmap>& placed) const {
    std::vector<const PlacedSubmap*> fresh;
    for (const PlacedSubmap& one : placed) {
      if (counted.count(one.submap->id) == 0) fresh.push_back(&one);
    }
    std::sort(fresh.begin(), fresh.end(), [](const PlacedSubmap* x, const PlacedSubmap* y) {
      return Order(x->submap->last_stamp_ns, x->submap->id) <
             Order(y->submap->last_stamp_ns, y->submap->id);
    });
    if (fresh.size() > kMaxNewPerCall) fresh.resize(kMaxNewPerCall);
    return fresh;
  }

  // `look_ns`: when it looked, at the latest.
  void TakeIn(const PlacedSubmap& fresh, int64_t look_ns,
              const std::map<SubmapId, const PlacedSubmap*>& placed) {
    const std::shared_ptr<const PreparedSubmap> prepared = read(fresh.submap->id);
    Counted own;
    own.last_stamp_ns = fresh.submap->last_stamp_ns;
    own.is_readable = prepared != nullptr;
    if (!own.is_readable) {
      counted.emplace(fresh.submap->id, std::move(own));
      return;
    }
    LookAtOlder(fresh, *prepared, look_ns, placed);
    own.center = prepared->center();
    own.radius_m = prepared->radius_m();
    own.points = Sample(*prepared);
    own.looks.assign(own.points.size(), 0);
    counted.emplace(fresh.submap->id, std::move(own));
  }

  void LookAtOlder(const PlacedSubmap& fresh, const PreparedSubmap& prepared, int64_t look_ns,
                   const std::map<SubmapId, const PlacedSubmap*>& placed) {
    std::vector<std::tuple<double, SubmapId>> near;
    const Eigen::Vector3d middle = fresh.T_map_submap * prepared.center();
    for (const auto& [id, older] : counted) {
      const PlacedSubmap& there = *placed.at(id);
      if (there.component != fresh.component) continue;
      if (Order(older.last_stamp_ns, id) > Order(fresh.submap->last_stamp_ns, fresh.submap->id)) {
        continue;
      }
      const double apart = (there.T_map_submap * older.center - middle).norm();
      const double reach = kMaxRevisitApart * (older.radius_m + prepared.radius_m());
      if (apart < reach) near.emplace_back(apart, id);
    }
    std::sort(near.begin(), near.end());
    if (near.size() > kMaxOlder) near.resize(kMaxOlder);
    for (const auto& [apart, id] : near) {
      const PlacedSubmap& there = *placed.at(id);
      Counted& older = counted.at(id);
      const RobotId& robot = fresh.submap->robot;
      if (robot != there.submap->robot && robot == older.last_look) continue;
      const Pose T_fresh_older = fresh.T_map_submap.Inverse() * there.T_map_submap;
      if (!Count(prepared, T_fresh_older, &older)) continue;
      older.last_look = robot;
      if (fresh.submap->id.session != id.session) {
        older.looked_ns = std::max(older.looked_ns, look_ns);
      }
      if (!older.due_ns && IsSeenEnough(older)) older.due_ns = older.looked_ns;
    }
  }

  // False where it does not count.
  bool Count(const PreparedSubmap& later, const Pose& T_later_older, Counted* older) const {
    const std::vector<Visibility> looks = VisibilityOf(older->points, later, T_later_older);
    const auto on = std::count(looks.begin(), looks.end(), Visibility::kOn);
    const auto through = std::count(looks.begin(), looks.end(), Visibility::kThrough);
    if (on + through < kMinSeenPoints || through > on) return false;
    for (size_t i = 0; i < looks.size(); ++i) {
      if (looks[i] == Visibility::kNone || older->looks[i] >= options.min_looks) continue;
      ++older->looks[i];
    }
    return true;
  }

  bool IsSeenEnough(const Counted& one) const {
    const auto often = std::count_if(one.looks.begin(), one.looks.end(),
                                     [&](uint8_t looks) { return looks >= options.min_looks; });
    return static_cast<double>(often) >= options.min_share * static_cast<double>(one.looks.size());
  }

  bool MayGo(const SubmapId& id, int64_t now_ns) const {
    const auto found = counted.find(id);
    if (found == counted.end() || !found->second.due_ns) return false;
    const int64_t since_ns = *found->second.due_ns;
    return static_cast<double>(now_ns - since_ns) >= options.grace_h * kNsPerHour;
  }

  // The submaps of each session but its newest, in order of id.
  std::vector<SubmapId> WhatMayGo(const std::map<SubmapId, const PlacedSubmap*>& placed,
                                  int64_t now_ns) {
    std::map<SessionId, std::vector<SubmapId>> sessions;
    for (const auto& [id, one] : placed) sessions[id.session].push_back(id);
    std::vector<SubmapId> going;
    for (const auto& [session, ids] : sessions) {
      const auto keep = static_cast<size_t>(std::max(options.keep_newest, 0));
      std::vector<SubmapId> of_session;
      for (size_t i = 0; i + keep < ids.size(); ++i) {
        if (!MayGo(ids[i], now_ns)) continue;
        if (IsCrowded(ids[i], of_session, placed)) continue;
        of_session.push_back(ids[i]);
      }
      const double share = kMinBatchShare * static_cast<double>(ids.size());
      const bool worth = of_session.size() >= kMinBatch ||
                         (!of_session.empty() && static_cast<double>(of_session.size()) >= share);
      if (worth) going.insert(going.end(), of_session.begin(), of_session.end());
    }
    return going;
  }

  // True if enough of the same place go already.
  bool IsCrowded(const SubmapId& id, const std::vector<SubmapId>& going,
                 const std::map<SubmapId, const PlacedSubmap*>& placed) const {
    const Counted& one = counted.at(id);
    const Eigen::Vector3d center = placed.at(id)->T_map_submap * one.center;
    const auto of_place = std::count_if(going.begin(), going.end(), [&](const SubmapId& other) {
      const Counted& there = counted.at(other);
      const double apart = (placed.at(other)->T_map_submap * there.center - center).norm();
      return apart < kSamePlaceShare * (one.radius_m + there.radius_m);
    });
    return static_cast<size_t>(of_place) >= kMaxOfAPlace;
  }

  RevisitOptions options;
  PreparedReader read;
  std::map<SubmapId, Counted> counted;
};

RevisitCounter::RevisitCounter(const RevisitOptions& options, PreparedReader prepared)
    : state_(std::make_unique<State>(options, std::move(prepared))) {}

RevisitCounter::~RevisitCounter() = default;

std::vector<SubmapId> RevisitCounter::Update(const std::vector<PlacedSubmap>& placed,
                                             int64_t now_ns, const FinishReader& finished_ns) {
  if (!state_->options.retire) return {};
  std::map<SubmapId, const PlacedSubmap*> by_id;
  for (const PlacedSubmap& one : placed) by_id[one.submap->id] = &one;
  state_->Forget(by_id);
  for (const PlacedSubmap* fresh : state_->TakeNew(placed)) {
    const int64_t ended_ns = finished_ns(fresh->submap->id.session);
    // A clock that was set back since makes nothing wait longer.
    const int64_t look_ns = ended_ns > 0 ? std::min(ended_ns, now_ns) : now_ns;
    state_->TakeIn(*fresh, look_ns, by_id);
  }
  return state_->WhatMayGo(by_id, now_ns);
}

}  // namespace isthmus::matching
