#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <filesystem>
#include <map>
#include <utility>

#include "client/evaluation/picture.h"
#include "client/report/evaluation_figures.h"
#include "client/report/limits.h"
#include "client/report/server_page.h"
#include "core/io/file_io.h"

namespace isthmus::report {
namespace {

using cli::Json;

const char* KindOf(const MatchEdge& edge) {
  if (edge.in_tree) return "tree";
  if (edge.match.state == MatchState::kAccepted) return "accepted";
  return edge.match.state == MatchState::kRejected ? "rejected" : "open";
}

// Why, and how probable it is, where that was computed and is not overruled.
std::string LabelOf(const Match& match) {
  const std::string reason = ToString(match.reason);
  const bool is_computed = match.confidence > 0 && match.reason != MatchReason::kByHand;
  return is_computed ? absl::StrFormat("%s %.2f", reason, match.confidence) : reason;
}

// Null where there is nothing to show, or too much.
Figure GraphFigure(const MatchGraph& graph) {
  std::map<SessionId, uint32_t> components;
  for (const PlacedSession& placed : graph.placements) {
    components[placed.placement.session] = placed.placement.component;
  }
  Figure figure = {{"file", "match_graph"},
                   {"kind", "graph"},
                   {"title", "Match graph"},
                   {"nodes", Json::array()},
                   {"edges", Json::array()}};
  std::map<uint32_t, std::vector<SessionId>> by_component;
  for (const MatchEdge& edge : graph.matches) {
    // A session without a place stands alone.
    for (const SessionId& session : {edge.match.a, edge.match.b}) {
      components.emplace(session, static_cast<uint32_t>(components.size()));
    }
    figure["edges"].push_back({{"a", edge.match.a.value()},
                               {"b", edge.match.b.value()},
                               {"kind", KindOf(edge)},
                               {"label", LabelOf(edge.match)}});
  }
  for (const auto& [session, component] : components) by_component[component].push_back(session);
  for (const auto& [component, sessions] : by_component) {
    for (const SessionId& session : sessions) {
      figure["nodes"].push_back({{"name", session.value()}, {"component", component}});
    }
  }
  const bool is_readable = components.size() >= 2 && components.size() <= kGraphSessions;
  return is_readable ? figure : Figure(nullptr);
}

absl::StatusOr<Figure> MapFigure(const ComponentMap& map, const std::string& folder) {
  const std::string file = absl::StrCat("map_", map.component);
  evaluation::PictureOptions options;
  options.max_side_px = kMapSidePx;
  options.legend = false;
  const Box extent = evaluation::PictureExtent(map.points, map.ways);
  std::vector<std::string> names;
  for (const RobotId& robot : map.robots) names.push_back(robot.value());
  auto picture = evaluation::TopDownPicture::Create(extent, names, options);
  if (!picture.ok()) return picture.status();
  picture->Add(map.points);
  const absl::Status written = picture->WritePng(absl::StrCat(folder, "/", file, "_points.png"));
  if (!written.ok()) return written;
  const double px = picture->meters_per_pixel();
  Figure figure = {{"file", file},
                   {"kind", "map"},
                   {"title", absl::StrCat("Map ", map.component)},
                   {"image", file + "_points.png"},
                   {"extent",
                    {extent.min.x(), extent.min.x() + px * picture->width(),
                     extent.max.y() - px * picture->height(), extent.max.y()}},
                   {"series", Json::array()}};
  std::vector<bool> has_points(map.robots.size());
  for (const MapPoint& point : map.points) {
    if (point.robot < has_points.size()) has_points[point.robot] = true;
  }
  for (size_t i = 0; i < map.robots.size(); ++i) {
    if (!has_points[i] && map.ways[i].empty()) continue;  // In another map.
    std::vector<double> x, y;
    for (const StampedPose& entry : map.ways[i]) {
      if (!entry.pose.IsFinite()) continue;
      x.push_back(entry.pose.translation().x());
      y.push_back(entry.pose.translation().y());
    }
    const evaluation::Color c = picture->RobotColor(static_cast<uint32_t>(i));
    figure["series"].push_back({{"name", names[i]},
                                {"color", absl::StrFormat("#%02x%02x%02x", c[0], c[1], c[2])},
                                {"way", {Thinned(x, kFigurePoints), Thinned(y, kFigurePoints)}}});
  }
  return figure;
}

}  // namespace

absl::StatusOr<std::vector<Figure>> FiguresOf(const ServerState& state, const std::string& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) return io::FileError("create folder", folder, failed.value());
  std::vector<Figure> figures;
  for (const ComponentMap& map : state.maps) {
    auto figure = MapFigure(map, folder);
    if (!figure.ok()) return figure.status();
    figures.push_back(*std::move(figure));
  }
  if (Figure graph = GraphFigure(state.graph); !graph.is_null()) {
    figures.push_back(std::move(graph));
  }
  return figures;
}

}  // namespace isthmus::report
