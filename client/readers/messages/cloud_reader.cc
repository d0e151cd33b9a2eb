#include "client/readers/messages/cloud_reader.h"

#include <absl/strings/str_cat.h>

#include <atomic>
#include <utility>

#include "client/readers/messages/decode/cloud_message.h"
#include "client/readers/ring_sensor.h"
#include "client/readers/stamps.h"

namespace isthmus::readers {
namespace {

class CloudReader : public ScanReader {
 public:
  CloudReader(const MessageTopic& topic, ScanMessage kind, std::unique_ptr<MessageReader> messages,
              const ReadOptions& options)
      : topic_(topic),
        kind_(kind),
        messages_(std::move(messages)),
        options_(options),
        stamps_(options.stamps, options.rate_hz) {}

  absl::StatusOr<std::optional<RecordedScan>> Next() override;
  std::optional<uint64_t> size() const override { return topic_.messages; }
  std::string sensor() const override;
  std::vector<std::string> Assumptions() const override {
    std::vector<std::string> all = messages_->Assumptions();
    for (std::string& one : stamps_.Assumptions()) all.push_back(std::move(one));
    return all;
  }
  void Interrupt() override { interrupted_ = true; }

 private:
  absl::StatusOr<CloudMessage> Decode(absl::string_view bytes) const;
  absl::StatusOr<RecordedScan> Make(const Message& message);

  const MessageTopic topic_;
  const ScanMessage kind_;
  const std::unique_ptr<MessageReader> messages_;
  const ReadOptions options_;
  ScanStamps stamps_;
  RingSensor rings_;
  size_t next_ = 0;  // The number of the next message.
  std::atomic<bool> interrupted_ = false;
};

absl::StatusOr<CloudMessage> CloudReader::Decode(absl::string_view bytes) const {
  if (kind_ == ScanMessage::kLivox) return DecodeLivox(topic_.encoding, bytes);
  if (kind_ == ScanMessage::kFoxglove) return DecodeFoxglove(bytes);
  return DecodePointCloud2(topic_.encoding, bytes);
}

absl::StatusOr<RecordedScan> CloudReader::Make(const Message& message) {
  absl::StatusOr<CloudMessage> cloud = Decode(message.bytes);
  if (!cloud.ok()) return cloud.status();
  const int64_t end_ns = stamps_.End(cloud->payload, cloud->header.stamp_ns, message.log_ns);
  rings_.Look(cloud->payload);
  RecordedScan scan{end_ns, std::move(cloud->payload), {}};
  scan.frame = std::move(cloud->header.frame);
  return scan;
}

absl::StatusOr<std::optional<RecordedScan>> CloudReader::Next() {
  if (interrupted_) return std::nullopt;
  absl::StatusOr<std::optional<Message>> message = messages_->Next();
  if (!message.ok()) return message.status();
  if (!message->has_value()) return std::nullopt;
  const std::string name = absl::StrCat("scan ", next_++, " of ", topic_.name);
  absl::StatusOr<RecordedScan> scan = Make(**message);
  if (!scan.ok()) {
    return absl::Status(scan.status().code(), absl::StrCat(name, ": ", scan.status().message()));
  }
  scan->name = name;
  return *std::move(scan);
}

std::string CloudReader::sensor() const {
  if (!options_.sensor.empty()) return options_.sensor;
  return kind_ == ScanMessage::kLivox ? "livox" : rings_.sensor();
}

}  // namespace

std::unique_ptr<ScanReader> ReadClouds(const MessageTopic& topic, ScanMessage kind,
                                       std::unique_ptr<MessageReader> messages,
                                       const ReadOptions& options) {
  return std::make_unique<CloudReader>(topic, kind, std::move(messages), options);
}

}  // namespace isthmus::readers
