// Conversion between the API's messages and the records of this library. Private to the library.
#pragma once

#include <absl/status/status.h>

#include <optional>

#include "client/library/records.h"
#include "client/library/stream/scan_stream.h"
#include "isthmus/v1/graph_service.pb.h"
#include "isthmus/v1/map_service.pb.h"
#include "isthmus/v1/match_service.pb.h"
#include "isthmus/v1/session_service.pb.h"

namespace isthmus::client {

v1::Pose ToProto(const Pose& pose);
v1::CreateSessionRequest ToProto(const SessionWish& wish);
v1::PointCloud ToProto(PointPayload payload);
v1::Box ToProto(const Box& box);
v1::QueryRegionRequest ToProto(const RegionQuery& query);
v1::DecideMatchRequest ToProto(const MatchDecision& decision);
v1::DecideLoopRequest ToProto(const LoopDecision& decision);
v1::Anchor ToProto(const Anchor& anchor);
v1::ExportMapRequest ToProto(const ExportRequest& request);
// `size` and `crc32c` of the cloud's data, which the header leaves out.
v1::UploadSubmapHeader ToProto(const SubmapUpload& submap);

// A symmetric matrix from 21 numbers, row by row; nothing if there are not as many.
std::optional<Matrix6d> FromUpperTriangle(const google::protobuf::RepeatedField<double>& numbers);
Pose FromProto(const v1::Pose& pose);
Box FromProto(const v1::Box& box);
ScanCounts FromProto(const v1::ScanCounts& counts);
Session FromProto(const v1::Session& session);
MapInfo FromProto(const v1::MapInfo& info);
SubmapStatus FromProto(const v1::Submap& submap);
SubmapEdge FromProto(const v1::SubmapEdge& edge);
MatchEdge FromProto(const v1::Match& match);
MatchGraph FromProto(const v1::MatchGraph& graph);
RevisionInfo FromProto(const v1::Revision& revision);
SubmapMove FromProto(const v1::SubmapMove& move);
Loop FromProto(const v1::Loop& loop);
RobotAnchor FromProto(const v1::Anchor& anchor);
ScanAck FromProto(const v1::StreamScansResponse& ack);

// DataLoss when the cloud is not laid out as the API promises (x y z intensity robot, RAW).
absl::Status AppendPoints(const v1::PointCloud& cloud, std::vector<MapPoint>& points);

}  // namespace isthmus::client
