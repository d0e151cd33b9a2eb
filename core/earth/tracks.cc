#include "core/earth/tracks.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_replace.h>

#include <utility>

#include "core/earth/geojson.h"

namespace isthmus::earth {
namespace {

using nlohmann::ordered_json;

std::string Escaped(const std::string& text) {
  return absl::StrReplaceAll(text, {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}});
}

}  // namespace

std::string FormatGeoJson(const std::vector<Track>& tracks, const Site& site) {
  ordered_json features = ordered_json::array();
  for (const Track& track : tracks) {
    if (track.poses.empty()) continue;
    ordered_json line = ordered_json::array();
    for (const StampedPose& pose : track.poses) {
      line.push_back(PositionOf(pose.pose.translation(), site));
    }
    const ordered_json properties = {{"robot", track.robot.value()},
                                     {"session", track.session.value()},
                                     {"begin", UtcText(track.poses.front().stamp_ns)},
                                     {"end", UtcText(track.poses.back().stamp_ns)}};
    features.push_back(line.size() > 1 ? FeatureOf(properties, "LineString", line)
                                       : FeatureOf(properties, "Point", line.front()));
  }
  return FormatFeatures(std::move(features));
}

std::string FormatKml(const std::vector<Track>& tracks, const Site& site) {
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
      const Geodetic place = site.ToGeodetic(pose.pose.translation());
      absl::StrAppendFormat(&kml, "%.9f,%.9f,%.3f\n", place.longitude_deg, place.latitude_deg,
                            place.altitude_m);
    }
    absl::StrAppend(&kml, "</coordinates></LineString>\n</Placemark>\n");
  }
  return kml + "</Document>\n</kml>\n";
}

}  // namespace isthmus::earth
