#include "client/exports/earth_tracks.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_replace.h>
#include <absl/time/time.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace isthmus::exports {
namespace {

using nlohmann::ordered_json;

std::string UtcText(int64_t stamp_ns) {
  return absl::FormatTime("%Y-%m-%dT%H:%M:%E3SZ", absl::FromUnixNanos(stamp_ns),
                          absl::UTCTimeZone());
}

// To a part of one: a billionth of a degree is a tenth of a millimetre.
double Rounded(double value, double parts) { return std::round(value * parts) / parts; }

ordered_json PositionOf(const StampedPose& pose, const georeference::Site& site) {
  const georeference::Geodetic place = site.ToGeodetic(pose.pose.translation());
  return {Rounded(place.longitude_deg, 1e9), Rounded(place.latitude_deg, 1e9),
          Rounded(place.altitude_m, 1e4)};
}

std::string Escaped(const std::string& text) {
  return absl::StrReplaceAll(text, {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}});
}

}  // namespace

std::string FormatGeoJson(const std::vector<Track>& tracks, const georeference::Site& site) {
  ordered_json features = ordered_json::array();
  for (const Track& track : tracks) {
    if (track.poses.empty()) continue;
    ordered_json coordinates = ordered_json::array();
    for (const StampedPose& pose : track.poses) coordinates.push_back(PositionOf(pose, site));
    const bool is_line = coordinates.size() > 1;
    features.push_back({{"type", "Feature"},
                        {"properties",
                         {{"robot", track.robot.value()},
                          {"session", track.session.value()},
                          {"begin", UtcText(track.poses.front().stamp_ns)},
                          {"end", UtcText(track.poses.back().stamp_ns)}}},
                        {"geometry",
                         {{"type", is_line ? "LineString" : "Point"},
                          {"coordinates", is_line ? coordinates : coordinates.front()}}}});
  }
  return ordered_json{{"type", "FeatureCollection"}, {"features", features}}.dump() + "\n";
}

std::string FormatKml(const std::vector<Track>& tracks, const georeference::Site& site) {
  std::string kml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n";
  for (const Track& track : tracks) {
    if (track.poses.empty()) continue;
    absl::StrAppend(&kml, "<Placemark>\n<name>", Escaped(track.robot.value()), "</name>\n",
                    "<description>", Escaped(track.session.value()), "</description>\n",
                    "<TimeSpan><begin>", UtcText(track.poses.front().stamp_ns), "</begin><end>",
                    UtcText(track.poses.back().stamp_ns), "</end></TimeSpan>\n",
                    "<LineString><altitudeMode>absolute</altitudeMode><coordinates>\n");
    for (const StampedPose& pose : track.poses) {
      const georeference::Geodetic place = site.ToGeodetic(pose.pose.translation());
      absl::StrAppendFormat(&kml, "%.9f,%.9f,%.3f\n", place.longitude_deg, place.latitude_deg,
                            place.altitude_m);
    }
    absl::StrAppend(&kml, "</coordinates></LineString>\n</Placemark>\n");
  }
  return kml + "</Document>\n</kml>\n";
}

}  // namespace isthmus::exports
