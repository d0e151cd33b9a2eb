#include "client/readers/packets/live_recording.h"

#include <absl/strings/str_cat.h>

#include <atomic>
#include <utility>

#include "client/readers/packets/limits.h"
#include "client/readers/packets/live/udp_socket.h"
#include "client/readers/packets/live/udp_uri.h"
#include "client/readers/packets/maker.h"
#include "client/readers/packets/packet_decoder.h"

namespace isthmus::readers {
namespace {

using live::UdpSocket;

class LiveScanReader : public ScanReader {
 public:
  LiveScanReader(std::unique_ptr<UdpSocket> socket, std::unique_ptr<PacketDecoder> decoder,
                 std::string name, const ReadOptions& options)
      : socket_(std::move(socket)),
        decoder_(std::move(decoder)),
        name_(std::move(name)),
        options_(options) {}

  absl::StatusOr<std::optional<RecordedScan>> Next() override {
    while (!ended_ && !interrupted_) {
      while (ready_ < scans_.size()) {
        RecordedScan scan = std::move(scans_[ready_++]);
        const size_t index = index_++;
        if (index < options_.from) continue;
        if (options_.to && index > *options_.to) break;
        absl::StrAppend(&scan.name, " of ", name_);
        return scan;
      }
      if (options_.to && index_ > *options_.to) break;
      const bool had_scans = !scans_.empty();
      scans_.clear();
      ready_ = 0;
      if (had_scans && socket_->dropped() > told_dropped_) return TellDropped();
      const absl::StatusOr<std::optional<UdpSocket::Arrived>> arrived = socket_->Receive();
      if (!arrived.ok()) {
        ended_ = true;
        return arrived.status();
      }
      if (!*arrived) break;
      if (const absl::Status status = Take(**arrived); !status.ok()) return status;
    }
    ended_ = true;
    return std::nullopt;
  }

  std::string sensor() const override { return decoder_ ? decoder_->sensor() : options_.sensor; }
  std::vector<std::string> Assumptions() const override {
    return decoder_ ? decoder_->Assumptions() : std::vector<std::string>();
  }
  void Interrupt() override {
    interrupted_ = true;
    socket_->Interrupt();
  }

 private:
  absl::Status TellDropped() {
    const uint64_t dropped = socket_->dropped() - told_dropped_;
    told_dropped_ = socket_->dropped();
    return absl::DataLossError(absl::StrCat(
        dropped, " packets were lost before ", name_, " was read: the buffer of ",
        socket_->buffer_bytes() >> 10, " KiB was full; read faster",
        socket_->buffer_bytes() < kReceiveBufferBytes
            ? absl::StrCat(
                  ", or allow a larger one (sysctl net.core.rmem_max=", kReceiveBufferBytes, ")")
            : std::string()));
  }

  // Packets that are not the sensor's are reported once.
  absl::Status Foreign(const absl::Status& status) {
    return std::exchange(told_foreign_, true) ? absl::OkStatus() : status;
  }

  absl::Status Take(const UdpSocket::Arrived& arrived) {
    if (!decoder_) {
      const std::optional<Maker> maker = MakerOf(arrived.payload, arrived.payload.size());
      if (!maker) {
        if (++unknown_ < kMaxForeignPackets) return absl::OkStatus();
        return Foreign(absl::InvalidArgumentError(
            absl::StrCat("what comes to ", name_, " is no point data of ", kKnownMakers)));
      }
      absl::StatusOr<std::unique_ptr<PacketDecoder>> decoder =
          MakeDecoder(*maker, options_, std::nullopt, "", arrived.payload.size());
      if (!decoder.ok()) {
        ended_ = true;
        return decoder.status();
      }
      decoder_ = *std::move(decoder);
    }
    if (source_ && arrived.source != *source_) return TakeOther(arrived);
    const absl::Status status = decoder_->Add(arrived.payload, arrived.arrival_ns, &scans_);
    if (absl::IsFailedPrecondition(status)) {
      ended_ = true;
      return status;
    }
    if (!status.ok()) {
      return Foreign(absl::Status(status.code(), absl::StrCat(name_, ": ", status.message())));
    }
    source_ = arrived.source;
    return absl::OkStatus();
  }

  absl::Status TakeOther(const UdpSocket::Arrived& arrived) {
    if (!MakerOf(arrived.payload, arrived.payload.size())) return absl::OkStatus();
    if (std::exchange(told_other_, true)) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat(
        "a second sensor, ", arrived.source.Text(), ", sends to ", name_,
        ", too: its packets are left out; let it send to another port, and read that as another"));
  }

  std::unique_ptr<UdpSocket> socket_;
  std::atomic<bool> interrupted_ = false;
  std::unique_ptr<PacketDecoder> decoder_;  // Null before the first packet.
  const std::string name_;
  const ReadOptions options_;
  std::optional<capture::IpAddress> source_;
  std::vector<RecordedScan> scans_;  // From ready_ on: to be given.
  size_t ready_ = 0, index_ = 0;
  uint64_t told_dropped_ = 0, unknown_ = 0;
  bool ended_ = false, told_foreign_ = false, told_other_ = false;
};

class LiveRecording : public Recording {
 public:
  LiveRecording(std::string uri, const live::UdpUri& address)
      : uri_(std::move(uri)),
        address_(address),
        topics_{{absl::StrCat("udp ", address.port), "live packets"}} {}

  std::string kind() const override { return "live sensor"; }
  const std::vector<ScanTopic>& scan_topics() const override { return topics_; }

 private:
  absl::StatusOr<std::unique_ptr<ScanReader>> OpenAllScans(
      size_t, const ReadOptions& options) const override {
    std::unique_ptr<PacketDecoder> decoder;
    // Faults in the options show now, not at the first packet.
    if (!options.sensor.empty() || !options.metadata.empty()) {
      const absl::StatusOr<Maker> maker =
          options.sensor.empty() ? Maker::kOuster : MakerOfSensor(options.sensor);
      if (!maker.ok()) return maker.status();
      absl::StatusOr<std::unique_ptr<PacketDecoder>> made =
          MakeDecoder(*maker, options, std::nullopt, "", 0);
      if (!made.ok()) return made.status();
      decoder = *std::move(made);
    }
    absl::StatusOr<std::unique_ptr<UdpSocket>> socket = UdpSocket::Open(address_);
    if (!socket.ok()) {
      return absl::Status(socket.status().code(),
                          absl::StrCat(uri_, ": ", socket.status().message()));
    }
    return std::make_unique<LiveScanReader>(*std::move(socket), std::move(decoder), topics_[0].name,
                                            options);
  }

  const std::string uri_;
  const live::UdpUri address_;
  const std::vector<ScanTopic> topics_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Recording>> OpenLiveRecording(const std::string& uri) {
  const absl::StatusOr<live::UdpUri> address = live::ParseUdpUri(uri);
  if (!address.ok()) return address.status();
  return std::make_unique<LiveRecording>(uri, *address);
}

}  // namespace isthmus::readers
