#include "client/readers/messages/packet_reader.h"

#include <absl/strings/str_cat.h>

#include <atomic>
#include <deque>
#include <utility>

#include "client/readers/messages/decode/packet_message.h"
#include "client/readers/messages/limits.h"

namespace isthmus::readers {
namespace {

class PacketReader : public ScanReader {
 public:
  PacketReader(const MessageTopic& topic, std::unique_ptr<MessageReader> messages,
               const ReadOptions& options, DecoderMaker make_decoder)
      : topic_(topic),
        list_(PacketListOf(topic)),
        messages_(std::move(messages)),
        options_(options),
        make_decoder_(std::move(make_decoder)) {}

  absl::StatusOr<std::optional<RecordedScan>> Next() override;
  std::string sensor() const override {
    if (!options_.sensor.empty() || decoder_ == nullptr) return options_.sensor;
    return decoder_->sensor();
  }
  std::vector<std::string> Assumptions() const override {
    std::vector<std::string> all = messages_->Assumptions();
    if (decoder_ == nullptr) return all;
    for (std::string& one : decoder_->Assumptions()) all.push_back(std::move(one));
    return all;
  }
  void Interrupt() override { interrupted_ = true; }

 private:
  absl::Status Take(const Message& message);
  // Unless there is one. Where it cannot be made, the recording has ended.
  absl::Status MakeDecoder(const MessagePacket& packet);
  absl::Status AddAll(const std::vector<MessagePacket>& packets);
  // The packets that were refused since the last report; OK where none was.
  absl::Status Refused();
  // The next scan that is ready and wanted.
  std::optional<RecordedScan> TakeReady();

  const MessageTopic topic_;
  const std::optional<PacketList> list_;  // Else each message is one packet.
  const std::unique_ptr<MessageReader> messages_;
  const ReadOptions options_;
  const DecoderMaker make_decoder_;
  std::unique_ptr<PacketDecoder> decoder_;
  bool turns_ = false;  // Messages are whole turns.
  bool ended_ = false;
  size_t next_ = 0;    // The number of the next scan.
  std::string frame_;  // The newest message's.
  std::deque<RecordedScan> ready_;
  uint64_t refused_ = 0;  // Packets.
  std::string why_refused_;
  std::atomic<bool> interrupted_ = false;
};

absl::Status PacketReader::MakeDecoder(const MessagePacket& packet) {
  if (decoder_ != nullptr) return absl::OkStatus();
  absl::StatusOr<std::unique_ptr<PacketDecoder>> decoder = make_decoder_(packet.bytes, turns_);
  if (!decoder.ok()) {
    ended_ = true;
    return decoder.status();
  }
  decoder_ = *std::move(decoder);
  if (decoder_ != nullptr) return absl::OkStatus();
  return absl::InvalidArgumentError("a packet is of no sensor that is known");
}

absl::Status PacketReader::AddAll(const std::vector<MessagePacket>& packets) {
  if (!packets.empty()) frame_ = packets.front().frame;
  if (decoder_ == nullptr) turns_ = packets.size() >= kMinTurnPackets;
  std::vector<RecordedScan> scans;
  for (const MessagePacket& packet : packets) {
    absl::Status added = MakeDecoder(packet);
    if (ended_) return added;
    if (added.ok()) added = decoder_->Add(packet.bytes, packet.arrival_ns, &scans);
    if (added.ok()) continue;
    if (refused_++ == 0) why_refused_ = std::string(added.message());
    if (!absl::IsFailedPrecondition(added)) continue;
    ended_ = true;
    break;
  }
  if (turns_ && decoder_ != nullptr) decoder_->Flush(&scans);
  for (RecordedScan& scan : scans) ready_.push_back(std::move(scan));
  return absl::OkStatus();
}

absl::Status PacketReader::Take(const Message& message) {
  absl::StatusOr<std::vector<MessagePacket>> packets =
      list_ ? DecodePacketList(*list_, topic_.encoding, message.bytes, message.log_ns)
            : DecodeOusterPacket(topic_.encoding, message.bytes, message.log_ns);
  if (packets.ok()) return AddAll(*packets);
  if (refused_++ == 0) why_refused_ = std::string(packets.status().message());
  return absl::OkStatus();
}

absl::Status PacketReader::Refused() {
  if (refused_ == 0) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(topic_.name, ": packets left out before scan ",
                                                 next_, ": ", std::exchange(refused_, 0), " (",
                                                 why_refused_, ")"));
}

std::optional<RecordedScan> PacketReader::TakeReady() {
  if (ready_.empty()) return std::nullopt;
  RecordedScan scan = std::move(ready_.front());
  ready_.pop_front();
  scan.name = absl::StrCat("scan ", next_++, " of ", topic_.name);
  scan.frame = frame_;
  return scan;
}

absl::StatusOr<std::optional<RecordedScan>> PacketReader::Next() {
  while (!interrupted_) {
    // Refused packets are reported with the next scan, once for all.
    if (!ready_.empty() || ended_) {
      if (absl::Status refused = Refused(); !refused.ok()) return refused;
    }
    if (std::optional<RecordedScan> scan = TakeReady()) return scan;
    if (ended_) break;
    absl::StatusOr<std::optional<Message>> message = messages_->Next();
    if (!message.ok()) return message.status();
    if (message->has_value()) {
      if (absl::Status status = Take(**message); !status.ok()) return status;
      continue;
    }
    ended_ = true;
    std::vector<RecordedScan> scans;
    if (decoder_ != nullptr) decoder_->Flush(&scans);
    for (RecordedScan& scan : scans) ready_.push_back(std::move(scan));
  }
  return std::nullopt;
}

}  // namespace

std::unique_ptr<ScanReader> ReadPackets(const MessageTopic& topic,
                                        std::unique_ptr<MessageReader> messages,
                                        const ReadOptions& options, DecoderMaker make_decoder) {
  return std::make_unique<PacketReader>(topic, std::move(messages), options,
                                        std::move(make_decoder));
}

}  // namespace isthmus::readers
