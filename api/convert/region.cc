// Parts of the merged map that are asked for, as points or as files.
#include <absl/strings/str_cat.h>

#include <optional>
#include <string>
#include <utility>

#include "api/convert/enum_table.h"
#include "api/convert/geometry.h"
#include "api/convert/map.h"
#include "api/convert/map_name.h"
#include "api/convert/region_place.h"

namespace isthmus::convert {
namespace {

// As the API says, and what core/codec takes.
constexpr double kDefaultRoundingM = 0.001, kMinRoundingM = 1e-5, kMaxRoundingM = 0.1;

constexpr std::pair<ExportFormat, v1::ExportMapRequest::Format> kFormats[] = {
    {ExportFormat::kPcdAscii, v1::ExportMapRequest::PCD_ASCII},
    {ExportFormat::kPcdBinary, v1::ExportMapRequest::PCD_BINARY},
    {ExportFormat::kPcdBinaryCompressed, v1::ExportMapRequest::PCD_BINARY_COMPRESSED},
    {ExportFormat::kPly, v1::ExportMapRequest::PLY},
    {ExportFormat::kOctoMapBinary, v1::ExportMapRequest::OCTOMAP_BINARY},
    {ExportFormat::kOctoMapFull, v1::ExportMapRequest::OCTOMAP_FULL},
};

absl::Status CheckResolution(double resolution_m) {
  if (resolution_m >= 0 && resolution_m <= kMaxCoordinateM) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("resolution_m is ", resolution_m, ": give 0 to ",
                                                 kMaxCoordinateM,
                                                 " m; 0 is the points as composed"));
}

absl::Status CheckLeaf(double resolution_m) {
  const bool is_leaf = resolution_m >= kLeastLeafM && resolution_m <= kMostLeafM;
  if (is_leaf || resolution_m == 0) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("resolution_m is ", resolution_m, ": give ",
                                                 kLeastLeafM, " to ", kMostLeafM,
                                                 " m, or 0 for the default"));
}

using Attribute = v1::QueryRegionRequest::Attribute;

void PutAttributes(const RegionQuery& query, v1::QueryRegionRequest& message) {
  if (query.wants_intensity) message.add_attributes(v1::QueryRegionRequest::INTENSITY);
  if (query.wants_robot) message.add_attributes(v1::QueryRegionRequest::ROBOT);
  if (query.wants_stamp) message.add_attributes(v1::QueryRegionRequest::LAST_SEEN);
  if (query.wants_label) message.add_attributes(v1::QueryRegionRequest::LABEL);
  // None at all: an empty list would be the usual ones.
  if (message.attributes().empty()) {
    message.add_attributes(v1::QueryRegionRequest::ATTRIBUTE_UNSPECIFIED);
  }
}

absl::Status TakeAttributes(const v1::QueryRegionRequest& request, RegionQuery& query) {
  if (request.attributes().empty()) return absl::OkStatus();
  query.wants_intensity = query.wants_robot = false;
  for (const int attribute : request.attributes()) {
    switch (static_cast<Attribute>(attribute)) {
      case v1::QueryRegionRequest::ATTRIBUTE_UNSPECIFIED:
        break;
      case v1::QueryRegionRequest::INTENSITY:
        query.wants_intensity = true;
        break;
      case v1::QueryRegionRequest::ROBOT:
        query.wants_robot = true;
        break;
      case v1::QueryRegionRequest::LAST_SEEN:
        query.wants_stamp = true;
        break;
      case v1::QueryRegionRequest::LABEL:
        query.wants_label = true;
        break;
      default:
        return absl::InvalidArgumentError(
            absl::StrCat("attribute ", attribute,
                         " is not a field of points: give INTENSITY, ROBOT, LAST_SEEN or LABEL"));
    }
  }
  return absl::OkStatus();
}

template <typename Message>
void PutClasses(const std::vector<PointClass>& classes, Message& message) {
  for (const PointClass of : classes) message.add_classes(static_cast<v1::PointClass>(of));
}

// Their numbers are the same.
template <typename Message>
absl::StatusOr<std::vector<PointClass>> ClassesOf(const Message& message) {
  std::vector<PointClass> classes;
  for (const int of : message.classes()) {
    if (!v1::PointClass_IsValid(of)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "class ", of, " is not known to this server: give 0 to ", kPointClasses - 1));
    }
    classes.push_back(static_cast<PointClass>(of));
  }
  return classes;
}

// The range is that of core/codec.
absl::Status TakeEncoding(const v1::QueryRegionRequest& request, RegionQuery& query) {
  switch (request.encoding()) {
    case v1::PointCloud::ENCODING_UNSPECIFIED:
    case v1::PointCloud::RAW:
      return absl::OkStatus();
    case v1::PointCloud::QUANTIZED:
      break;
    case v1::PointCloud::DRACO:
      query.with_draco = true;
      break;
    default:
      return absl::InvalidArgumentError("the encoding is unknown: give RAW, QUANTIZED or DRACO");
  }
  query.rounding_m = request.rounding_m() == 0 ? kDefaultRoundingM : request.rounding_m();
  if (*query.rounding_m >= kMinRoundingM && *query.rounding_m <= kMaxRoundingM) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat("rounding_m is ", request.rounding_m(), ": give ",
                                                 kMinRoundingM, " to ", kMaxRoundingM));
}

}  // namespace

v1::QueryRegionRequest ToMessage(const RegionQuery& query) {
  v1::QueryRegionRequest message;
  PutPlace(query, message);
  PutMap(query.component, message);
  message.set_robot(query.robot.value());
  message.set_resolution_m(query.resolution_m);
  message.set_max_points(query.max_points);
  for (const SessionId& session : query.sessions) message.add_sessions(session.value());
  message.set_seen_from_ns(query.seen_from_ns);
  message.set_seen_to_ns(query.seen_to_ns);
  PutClasses(query.classes, message);
  PutAttributes(query, message);
  if (query.rounding_m || query.with_draco) {
    message.set_encoding(query.with_draco ? v1::PointCloud::DRACO : v1::PointCloud::QUANTIZED);
    message.set_rounding_m(query.rounding_m.value_or(0));
  }
  if (query.resume) *message.mutable_resume() = ToMessage(*query.resume);
  return message;
}

absl::StatusOr<RegionQuery> FromMessage(const v1::QueryRegionRequest& request) {
  RegionQuery query;
  if (absl::Status status = TakePlace(request, query); !status.ok()) return status;
  if (absl::Status status = CheckResolution(request.resolution_m()); !status.ok()) return status;
  query.component = MapOf(request);
  query.robot = RobotId(request.robot());
  query.resolution_m = request.resolution_m();
  query.max_points = request.max_points();
  for (const std::string& session : request.sessions()) query.sessions.emplace_back(session);
  query.seen_from_ns = request.seen_from_ns();
  query.seen_to_ns = request.seen_to_ns();
  if (query.seen_to_ns != 0 && query.seen_from_ns > query.seen_to_ns) {
    return absl::InvalidArgumentError("seen_from_ns is after seen_to_ns: nothing is seen between");
  }
  auto classes = ClassesOf(request);
  if (!classes.ok()) return classes.status();
  query.classes = *std::move(classes);
  if (absl::Status status = TakeAttributes(request, query); !status.ok()) return status;
  if (absl::Status status = TakeEncoding(request, query); !status.ok()) return status;
  if (request.has_resume()) query.resume = FromMessage(request.resume());
  return query;
}

v1::RegionPosition ToMessage(const RegionPosition& position) {
  v1::RegionPosition message;
  message.set_run(position.run);
  message.set_revision(position.revision);
  message.set_points(position.points);
  message.set_resolution_m(position.resolution_m);
  return message;
}

RegionPosition FromMessage(const v1::RegionPosition& position) {
  return {position.run(), position.revision(), position.points(), position.resolution_m()};
}

v1::ExportMapRequest ToMessage(const ExportRequest& request) {
  v1::ExportMapRequest message;
  message.set_format(ToMessage(kFormats, request.format));
  PutMap(request.component, message);
  message.set_resolution_m(request.resolution_m);
  PutPlace(request, message);
  message.set_robot(request.robot.value());
  message.set_dropped(request.dropped);
  PutClasses(request.classes, message);
  return message;
}

absl::StatusOr<ExportRequest> FromMessage(const v1::ExportMapRequest& request) {
  const auto format = FromMessage(kFormats, request.format(), std::optional<ExportFormat>());
  if (!format) {
    return absl::InvalidArgumentError(
        "name the format of the file: PCD_ASCII, PCD_BINARY, PCD_BINARY_COMPRESSED, PLY, "
        "OCTOMAP_BINARY or OCTOMAP_FULL");
  }
  ExportRequest wanted;
  if (absl::Status status = TakePlace(request, wanted); !status.ok()) return status;
  const bool has_leaves =
      *format == ExportFormat::kOctoMapBinary || *format == ExportFormat::kOctoMapFull;
  const double resolution_m = request.resolution_m();
  const absl::Status size = has_leaves ? CheckLeaf(resolution_m) : CheckResolution(resolution_m);
  if (!size.ok()) return size;
  wanted.format = *format;
  wanted.component = MapOf(request);
  wanted.resolution_m = resolution_m;
  wanted.robot = RobotId(request.robot());
  wanted.dropped = request.dropped();
  auto classes = ClassesOf(request);
  if (!classes.ok()) return classes.status();
  if (has_leaves && !classes->empty()) {
    return absl::InvalidArgumentError("an OctoMap has no classes: export them as PCD or PLY");
  }
  wanted.classes = *std::move(classes);
  return wanted;
}

}  // namespace isthmus::convert
