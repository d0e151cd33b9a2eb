#include "client/georeference/anchors_of_fixes.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "client/georeference/limits.h"
#include "client/georeference/way_on_fixes.h"
#include "core/earth/site.h"

namespace isthmus::georeference {
namespace {

struct PlaceAt {
  Eigen::Vector3d map;
  double sigma_xy_m = 0, sigma_z_m = 0;
};

using Places = std::map<int64_t, PlaceAt>;  // By stamp.

double SigmaOf(double stated, double unknown) {
  return stated > 0 ? std::max(stated, kLeastSigmaM) : unknown;
}

absl::StatusOr<Places> PlacesOf(const std::vector<readers::GnssFix>& fixes,
                                const earth::Site& site) {
  Places places;
  for (const readers::GnssFix& fix : fixes) {
    const Datum as_datum{fix.latitude_deg, fix.longitude_deg, fix.altitude_m};
    if (absl::Status status = CheckDatum(as_datum); !status.ok()) return status;
    places[fix.stamp_ns] = {
        site.ToMap({fix.latitude_deg, fix.longitude_deg, fix.altitude_m}),
        SigmaOf(std::max(fix.sigma_east_m, fix.sigma_north_m), kUnknownSigmaXyM),
        SigmaOf(fix.sigma_up_m, kUnknownSigmaZM)};
  }
  return places;
}

PlaceAt Between(const PlaceAt& before, const PlaceAt& after, double share) {
  return {before.map + share * (after.map - before.map),
          std::max(before.sigma_xy_m, after.sigma_xy_m),
          std::max(before.sigma_z_m, after.sigma_z_m)};
}

PlaceAt Later(PlaceAt place, double seconds) {
  place.sigma_xy_m = std::hypot(place.sigma_xy_m, kDriftMps * seconds);
  return place;
}

std::optional<PlaceAt> PlaceOf(int64_t stamp_ns, const Places& places) {
  const auto seconds = [](int64_t from, int64_t to) {
    return static_cast<double>(to - from) / 1e9;
  };
  const auto after = places.lower_bound(stamp_ns);
  const auto before = after == places.begin() ? places.end() : std::prev(after);
  const bool has_after = after != places.end(), has_before = before != places.end();
  if (has_after && after->first == stamp_ns) return after->second;
  const double since = has_before ? seconds(before->first, stamp_ns) : kLongestGapS + 1;
  const double until = has_after ? seconds(stamp_ns, after->first) : kLongestGapS + 1;
  if (since + until <= kLongestGapS) {
    return Between(before->second, after->second, since / (since + until));
  }
  if (std::min(since, until) > kLongestGapS) return std::nullopt;
  return since <= until ? Later(before->second, since) : Later(after->second, until);
}

// T_level_sensor: in the session's odom frame, made level.
Pose LevelPose(const SubmapInfo& submap, const Antenna& antenna) {
  return Pose(antenna.R_base_sensor, Eigen::Vector3d::Zero()) * submap.T_odom_submap;
}

// Takes out the antenna's offset from the sensor.
void TakeOut(const Eigen::Vector3d& off, const WayOnFixes& way, PlaceAt& place) {
  place.map.z() -= off.z();
  const double off_m = off.head<2>().norm();
  if (way.sigma_rad > kMostHeadingSigmaRad) {
    place.sigma_xy_m = std::hypot(place.sigma_xy_m, off_m);
    return;
  }
  place.map.head<2>() -= Eigen::Rotation2Dd(way.turn_rad) * off.head<2>();
  place.sigma_xy_m = std::hypot(place.sigma_xy_m, way.sigma_rad * off_m);
}

// A session's submaps, those of `own`: their sensors' places, but for those that are wild.
void PlaceSession(const std::vector<SubmapInfo>& submaps, const std::vector<size_t>& own,
                  const Antenna& antenna, std::vector<std::optional<PlaceAt>>& at,
                  FixedAnchors& made) {
  std::vector<AntennaPlace> on_way;
  on_way.reserve(own.size());
  for (const size_t i : own) {
    on_way.push_back({LevelPose(submaps[i], antenna), at[i]->map, at[i]->sigma_xy_m});
  }
  const WayOnFixes way = LayOnFixes(on_way, antenna.in_sensor);
  for (size_t k = 0; k < own.size(); ++k) {
    std::optional<PlaceAt>& place = at[own[k]];
    TakeOut(on_way[k].T_level_sensor.rotation() * antenna.in_sensor, way, *place);
    if (!way.is_wild[k]) continue;
    place.reset();
    ++made.wild;
  }
}

std::vector<std::optional<PlaceAt>> PlacesOfSubmaps(const std::vector<SubmapInfo>& submaps,
                                                    const Places& places, const Antenna& antenna,
                                                    FixedAnchors& made) {
  std::vector<std::optional<PlaceAt>> at;
  std::map<SessionId, std::vector<size_t>> sessions;
  for (size_t i = 0; i < submaps.size(); ++i) {
    at.push_back(PlaceOf(submaps[i].first_stamp_ns, places));
    if (at.back()) sessions[submaps[i].id.session].push_back(i);
  }
  for (const auto& [session, own] : sessions) PlaceSession(submaps, own, antenna, at, made);
  return at;
}

}  // namespace

absl::StatusOr<FixedAnchors> AnchorsOfFixes(std::vector<readers::GnssFix> fixes,
                                            const std::vector<SubmapInfo>& submaps,
                                            const std::optional<Datum>& datum,
                                            const Antenna& antenna) {
  if (fixes.empty()) return absl::NotFoundError("there are no fixes: no submap can be anchored");
  std::stable_sort(fixes.begin(), fixes.end(),
                   [](const auto& a, const auto& b) { return a.stamp_ns < b.stamp_ns; });
  FixedAnchors made;
  made.is_new_datum = !datum.has_value();
  const readers::GnssFix& first = fixes.front();
  made.datum = datum.value_or(Datum{first.latitude_deg, first.longitude_deg, first.altitude_m});
  const absl::StatusOr<earth::Site> site = earth::Site::Create(made.datum);
  if (!site.ok()) return site.status();
  const absl::StatusOr<Places> places = PlacesOf(fixes, *site);
  if (!places.ok()) return places.status();
  const std::vector<std::optional<PlaceAt>> at = PlacesOfSubmaps(submaps, *places, antenna, made);
  for (size_t i = 0; i < submaps.size(); ++i) {
    if (!at[i] || at[i]->map.cwiseAbs().maxCoeff() > kMaxAnchorM) continue;
    Anchor& anchor = made.anchors.emplace_back();
    anchor.submap = submaps[i].id;
    anchor.T_map_submap = Pose(Eigen::Quaterniond::Identity(), at[i]->map);
    anchor.sigma_xy_m = at[i]->sigma_xy_m;
    anchor.sigma_z_m = at[i]->sigma_z_m;
    anchor.note = "GNSS";
  }
  return made;
}

}  // namespace isthmus::georeference
