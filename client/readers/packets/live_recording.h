// Live sensors as recordings without an end.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>

#include "client/readers/recording.h"

namespace isthmus::readers {

// A sensor whose maker is known (maker.h) that sends to udp://[ADDRESS]:PORT: a literal address of
// this computer or a multicast group, which is joined; without one, all interfaces. One topic,
// which one reader at a time may read (but for groups); reading begins with OpenScans: Unavailable
// where the port is in use. The first packets tell the maker, unless ReadOptions::sensor says it;
// Ouster's need ReadOptions::metadata. Times are of arrival, or the sensor's where these agree.
//
// Next waits for the sensor until it is interrupted. Its errors: packets that the kernel dropped
// because scans were not taken in time, once for each scan at most; packets of a second sensor
// (another source address), which are left out, and of no known sensor, once each.
//
// InvalidArgument for anything but such a URI.
absl::StatusOr<std::unique_ptr<Recording>> OpenLiveRecording(const std::string& uri);

}  // namespace isthmus::readers
