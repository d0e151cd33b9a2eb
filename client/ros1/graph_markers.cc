#include "client/ros1/graph_markers.h"

#include <absl/strings/str_format.h>
#include <std_msgs/ColorRGBA.h>

#include <utility>

#include "client/ros1/graph_layout.h"
#include "client/ros1/limits.h"

namespace isthmus::ros1 {
namespace {

using visualization_msgs::Marker;

std_msgs::ColorRGBA Colour(float r, float g, float b, float a = 1) {
  std_msgs::ColorRGBA colour;
  colour.r = r;
  colour.g = g;
  colour.b = b;
  colour.a = a;
  return colour;
}

geometry_msgs::Point ToPoint(const Eigen::Vector3d& p) {
  geometry_msgs::Point point;
  point.x = p.x();
  point.y = p.y();
  point.z = p.z();
  return point;
}

class Drawing {
 public:
  explicit Drawing(const MarkerOptions& options) : options_(options) {
    Marker clear = Make("", 0, {});
    clear.action = Marker::DELETEALL;
    array_.markers.push_back(std::move(clear));
    accepted_ = Lines("accepted", Colour(0.1F, 0.8F, 0.2F));
    undecided_ = Lines("undecided", Colour(0.9F, 0.8F, 0.1F));
  }

  void AddNode(const SessionId& session, const GraphNode& node) {
    Marker ball = Make("sessions", Marker::SPHERE,
                       node.is_placed ? Colour(0.2F, 0.4F, 1) : Colour(0.5F, 0.5F, 0.5F, 0.5F));
    ball.pose.position = ToPoint(node.middle);
    ball.scale.x = ball.scale.y = ball.scale.z = options_.size_m;
    array_.markers.push_back(std::move(ball));
    AddText("names", session.value(), node.middle + Eigen::Vector3d(0, 0, options_.size_m));
  }

  void AddEdge(const Match& match, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const bool is_accepted = match.state == MatchState::kAccepted;
    Marker& lines = is_accepted ? accepted_ : undecided_;
    lines.points.push_back(ToPoint(a));
    lines.points.push_back(ToPoint(b));
    AddText("confidence",
            is_accepted ? absl::StrFormat("%.2f", match.confidence)
                        : absl::StrFormat("%.2f %s", match.confidence, ToString(match.reason)),
            (a + b) / 2);
  }

  visualization_msgs::MarkerArray Take() {
    for (Marker* lines : {&accepted_, &undecided_}) {
      if (!lines->points.empty()) array_.markers.push_back(std::move(*lines));
    }
    return std::move(array_);
  }

 private:
  Marker Make(const char* name_space, int32_t type, const std_msgs::ColorRGBA& colour) {
    Marker marker;
    marker.header.frame_id = options_.frame;
    marker.header.stamp = options_.stamp;
    marker.ns = name_space;
    marker.id = next_id_++;
    marker.type = type;
    marker.action = Marker::ADD;
    marker.pose.orientation.w = 1;
    marker.color = colour;
    return marker;
  }
  Marker Lines(const char* name_space, const std_msgs::ColorRGBA& colour) {
    Marker marker = Make(name_space, Marker::LINE_LIST, colour);
    marker.scale.x = kLineSizes * options_.size_m;
    return marker;
  }
  void AddText(const char* name_space, const std::string& text, const Eigen::Vector3d& at) {
    Marker marker = Make(name_space, Marker::TEXT_VIEW_FACING, Colour(1, 1, 1));
    marker.pose.position = ToPoint(at);
    marker.scale.z = kTextSizes * options_.size_m;
    marker.text = text;
    array_.markers.push_back(std::move(marker));
  }

  const MarkerOptions options_;
  visualization_msgs::MarkerArray array_;
  Marker accepted_, undecided_;
  int32_t next_id_ = 0;
};

}  // namespace

visualization_msgs::MarkerArray MakeMarkers(const MatchGraph& graph,
                                            const std::vector<SubmapStatus>& submaps,
                                            const MarkerOptions& options) {
  Drawing drawing(options);
  const auto nodes = LayOut(graph, submaps, options.component);
  for (const auto& [session, node] : nodes) drawing.AddNode(session, node);
  for (const MatchEdge& edge : graph.matches) {
    const auto a = nodes.find(edge.match.a), b = nodes.find(edge.match.b);
    const bool is_drawn = edge.match.state == MatchState::kAccepted || IsUndecided(edge.match);
    if (!is_drawn || a == nodes.end() || b == nodes.end()) continue;
    drawing.AddEdge(edge.match, a->second.middle, b->second.middle);
  }
  return drawing.Take();
}

}  // namespace isthmus::ros1
