// Captures of a sensor's packets as recordings: .pcap and .pcapng files.
#pragma once

#include <absl/status/statusor.h>

#include <cstdio>
#include <functional>
#include <memory>
#include <string>

#include "client/readers/recording.h"

namespace isthmus::readers {

// A topic of scans for each sensor, by the port it sent to and its address, whose packets are
// point data of a maker that is known (maker.h); of fixes for each that sent Velodyne's position
// packets with valid GPRMC sentences: latitude and longitude, but no height and no accuracy.
// Ethernet (with VLAN tags), Linux cooked, loopback and raw IP captures are read, IPv4 and IPv6,
// also in fragments.
//
// Reads the whole file once, which takes about a second for each GB, and holds no more of it than a
// packet and fragments of 16. Damaged files are read as far as they go; notes() and the last error
// of Next say what is missing. NotFound for a file that is not there or holds no such packets,
// InvalidArgument for one that is no capture.
absl::StatusOr<std::unique_ptr<Recording>> OpenPcapRecording(const std::string& path);

// The same for a capture that is not a file: `open` gives a new stream of it, which is closed when
// read, for each reader. `path` is its name in messages.
absl::StatusOr<std::unique_ptr<Recording>> OpenPcapRecording(const std::string& path,
                                                             std::function<FILE*()> open);

}  // namespace isthmus::readers
