// Messages that hold the points of a scan.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include "client/readers/messages/decode/message_fields.h"
#include "core/point_payload.h"

namespace isthmus::readers {

// A raw payload whose layout was checked (codec::CheckLayout), little endian, fields named as in
// the message.
struct CloudMessage {
  MessageHeader header;
  PointPayload payload;
};

// The functions below return InvalidArgument, naming what is wrong, for what does not fit.

// sensor_msgs/PointCloud2. Padding at the end of rows is taken out, numbers are put into little
// endian, a count of 0 is taken for 1, fields of unknown types are left out, and is_dense is not
// looked at.
absl::StatusOr<CloudMessage> DecodePointCloud2(absl::string_view encoding, absl::string_view bytes);

// CustomMsg of livox_ros_driver, livox_ros_driver2 and livox_interfaces. Fields x y z intensity
// (float32; the reflectivity), time (uint32, ns behind the header's stamp), ring (uint16; the
// line), tag (uint8).
absl::StatusOr<CloudMessage> DecodeLivox(absl::string_view encoding, absl::string_view bytes);

// foxglove.PointCloud as protobuf (foxglove.dev/docs, schemas). The pose in it (T_frame_cloud) is
// applied: points are in the frame that the message names.
absl::StatusOr<CloudMessage> DecodeFoxglove(absl::string_view bytes);

}  // namespace isthmus::readers
