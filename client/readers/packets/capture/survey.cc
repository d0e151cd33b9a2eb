#include "client/readers/packets/capture/survey.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cstdlib>
#include <map>

#include "client/readers/packets/limits.h"
#include "client/readers/packets/robosense/robosense_packet.h"
#include "client/readers/packets/velodyne/position_packet.h"
#include "client/readers/packets/velodyne/velodyne_packet.h"
#include "core/nanoseconds.h"

namespace isthmus::readers::capture {
namespace {

template <typename S>
S* StreamOf(const Datagram& datagram, std::vector<S>& streams) {
  for (S& known : streams) {
    if (known.stream.Has(datagram)) return &known;
  }
  if (streams.size() >= kMaxCaptureTopics) return nullptr;
  streams.emplace_back();
  streams.back().stream = {datagram.source, datagram.port};
  return &streams.back();
}

void CountPosition(const PcapFile::Arrived& arrived, const velodyne::PositionPacket& packet,
                   std::vector<ReceiverStream>& receivers) {
  const std::optional<velodyne::GprmcFix> fix = velodyne::ParseGprmc(packet.sentence);
  if (!fix) return;
  ReceiverStream* receiver = StreamOf(arrived.datagram, receivers);
  if (receiver == nullptr) return;
  ++receiver->packets;
  // The sentence is that of the last full second of the same clock.
  const int64_t sensor_ns = int64_t{packet.microseconds} * 1000;
  const int64_t behind_ns = ((sensor_ns - fix->stamp_ns) % kNsPerHour + kNsPerHour) % kNsPerHour;
  if (receiver->utc_offset_ns || behind_ns > kSentenceDelayNs) return;
  receiver->utc_offset_ns = fix->stamp_ns + behind_ns - arrived.arrival_ns;
}

}  // namespace

std::string Stream::Name() const { return absl::StrCat("udp ", port, " from ", source.Text()); }

Survey SurveyOf(PcapFile& file) {
  Survey survey;
  uint64_t others = 0, left_out = 0;
  std::map<std::string, std::string> difops;  // By address.
  while (const std::optional<PcapFile::Arrived> arrived = file.Next(/*headers_only=*/true)) {
    const Datagram& datagram = arrived->datagram;
    if (const std::optional<Maker> maker = MakerOf(datagram.payload, datagram.length)) {
      SensorStream* sensor = StreamOf(datagram, survey.sensors);
      if (sensor == nullptr) {
        ++left_out;
        continue;
      }
      if (sensor->packets++ > 0) continue;
      sensor->maker = *maker;
      sensor->packet_bytes = datagram.length;
      if (*maker == Maker::kVelodyne && datagram.payload.size() == datagram.length) {
        sensor->model = velodyne::ModelOf(velodyne::Packet(datagram.payload));
      }
    } else if (robosense::IsDifop(datagram.payload)) {
      const std::string source = datagram.source.Text();
      if (difops.size() < kMaxCaptureTopics) difops.try_emplace(source, datagram.payload);
    } else if (const auto position = velodyne::ParsePositionPacket(datagram.payload)) {
      CountPosition(*arrived, *position, survey.receivers);
    } else {
      ++others;
    }
  }
  for (SensorStream& sensor : survey.sensors) {
    if (sensor.maker == Maker::kRobosense) sensor.angles = difops[sensor.stream.source.Text()];
  }
  if (others > 0) {
    survey.notes.push_back(absl::StrCat(others, " datagrams are no points of a known sensor"));
  }
  if (left_out > 0) {
    survey.notes.push_back(absl::StrCat("only the first ", kMaxCaptureTopics, " sensors are read: ",
                                        left_out, " packets of others are left out"));
  }
  if (const std::string damage = file.Damage(); !damage.empty()) survey.notes.push_back(damage);
  return survey;
}

std::vector<GnssFix> FixesOf(PcapFile& file, const Stream& receiver) {
  std::vector<GnssFix> fixes;
  while (const std::optional<PcapFile::Arrived> arrived = file.Next()) {
    if (!receiver.Has(arrived->datagram)) continue;
    const auto packet = velodyne::ParsePositionPacket(arrived->datagram.payload);
    if (!packet) continue;
    const std::optional<velodyne::GprmcFix> parsed = velodyne::ParseGprmc(packet->sentence);
    // The sensor repeats a sentence until the next one comes.
    if (!parsed || (!fixes.empty() && fixes.back().stamp_ns == parsed->stamp_ns)) continue;
    if (fixes.size() >= kMaxFixes) break;
    GnssFix& fix = fixes.emplace_back();
    fix.stamp_ns = parsed->stamp_ns;
    fix.latitude_deg = parsed->latitude_deg;
    fix.longitude_deg = parsed->longitude_deg;
  }
  return fixes;
}

}  // namespace isthmus::readers::capture
