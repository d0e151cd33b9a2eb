// A first look at a capture: which sensors sent how much, and whether their clocks are UTC.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/readers/packets/capture/pcap_file.h"
#include "client/readers/packets/maker.h"
#include "client/readers/packets/velodyne/velodyne_model.h"
#include "client/readers/recording.h"

namespace isthmus::readers::capture {

// A sender and the port that it sent to.
struct Stream {
  IpAddress source;
  uint16_t port = 0;

  std::string Name() const;  // "udp 2368 from 192.168.1.201"
  bool Has(const Datagram& datagram) const {
    return datagram.port == port && datagram.source == source;
  }
};

struct SensorStream {
  Stream stream;
  Maker maker = Maker::kVelodyne;
  size_t packet_bytes = 0;
  uint64_t packets = 0;
  std::optional<velodyne::Model> model;  // As the first packet tells.
  std::string angles;                    // RoboSense's DIFOP packet from the same address; or none.
};

struct ReceiverStream {
  Stream stream;
  uint64_t packets = 0;  // With a valid fix.
  // UTC is arrival plus this, by the first fix that is the time of the sensor's clock; empty while
  // there is none.
  std::optional<int64_t> utc_offset_ns;
};

struct Survey {
  std::vector<SensorStream> sensors;
  std::vector<ReceiverStream> receivers;
  std::vector<std::string> notes;
};

// Reads all that the file holds.
Survey SurveyOf(PcapFile& file);

// The valid fixes of a receiver, in order, each once.
std::vector<GnssFix> FixesOf(PcapFile& file, const Stream& receiver);

}  // namespace isthmus::readers::capture
