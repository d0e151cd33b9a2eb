#include "client/readers/messages/message_recording.h"

#include <absl/strings/str_cat.h>

#include <cmath>
#include <map>
#include <utility>

#include "client/readers/messages/cloud_reader.h"
#include "client/readers/messages/decode/place_message.h"
#include "client/readers/messages/ouster_metadata.h"
#include "client/readers/messages/packet_reader.h"
#include "client/readers/messages/scan_topics.h"

namespace isthmus::readers {
namespace {

class MessageRecording : public Recording {
 public:
  MessageRecording(std::shared_ptr<const MessageFile> file, std::string path,
                   PacketDecoderFactories factories);

  std::string kind() const override { return file_->kind(); }
  const std::vector<ScanTopic>& scan_topics() const override { return scan_topics_; }
  std::vector<std::string> notes() const override { return notes_; }
  std::vector<GnssTopic> gnss_topics() const override { return gnss_topics_; }
  absl::StatusOr<std::vector<GnssFix>> ReadFixes(size_t gnss_topic) const override;
  absl::StatusOr<std::vector<StaticTransform>> ReadStaticTransforms() const override;

 private:
  absl::StatusOr<std::unique_ptr<ScanReader>> OpenAllScans(
      size_t topic, const ReadOptions& options) const override;
  absl::StatusOr<DecoderMaker> MakerOf(const MessageTopic& topic, ScanMessage kind,
                                       const ReadOptions& options) const;

  const std::shared_ptr<const MessageFile> file_;
  const std::string path_;
  const PacketDecoderFactories factories_;
  std::vector<ScanTopic> scan_topics_;
  std::vector<GnssTopic> gnss_topics_;
  std::vector<size_t> scan_indices_, gnss_indices_, transform_indices_;  // Into the file's topics.
  std::vector<std::string> notes_;
};

MessageRecording::MessageRecording(std::shared_ptr<const MessageFile> file, std::string path,
                                   PacketDecoderFactories factories)
    : file_(std::move(file)),
      path_(std::move(path)),
      factories_(std::move(factories)),
      notes_(file_->notes()) {
  for (size_t i = 0; i < file_->topics().size(); ++i) {
    const MessageTopic& topic = file_->topics()[i];
    if (ScanMessageOf(topic)) {
      scan_topics_.push_back({topic.name, topic.type, topic.messages});
      scan_indices_.push_back(i);
    } else if (IsFixTopic(topic)) {
      gnss_topics_.push_back({topic.name, topic.messages});
      gnss_indices_.push_back(i);
    } else if (IsStaticTransformTopic(topic)) {
      transform_indices_.push_back(i);
    } else if (HasOtherPoints(topic)) {
      notes_.push_back(absl::StrCat("the points of ", topic.name,
                                    " are not read: messages of type ", topic.type, " in ",
                                    topic.encoding, " are not understood"));
    }
  }
}

absl::StatusOr<DecoderMaker> MessageRecording::MakerOf(const MessageTopic& topic, ScanMessage kind,
                                                       const ReadOptions& options) const {
  const bool list = kind == ScanMessage::kPackets;
  if (list ? factories_.packets == nullptr : factories_.ouster == nullptr) {
    return absl::UnimplementedError(
        absl::StrCat("the packets of ", topic.name, " cannot be decoded in this build"));
  }
  if (!list) {
    absl::StatusOr<std::string> json =
        FindOusterMetadata(*file_, path_, topic.name, options.metadata);
    if (!json.ok()) return json.status();
    return [make = factories_.ouster, json = *std::move(json)](absl::string_view, bool) {
      return make(json);
    };
  }
  PacketOptions packets;
  packets.sensor = options.sensor;
  if (!options.calibration.empty()) {
    absl::StatusOr<std::string> text = ReadTextFile(options.calibration);
    if (!text.ok()) return text.status();
    packets.calibration = *std::move(text);
  }
  return [make = factories_.packets, packets](absl::string_view packet, bool messages_are_turns) {
    PacketOptions all = packets;
    all.by_flush = messages_are_turns;
    return make(packet, all);
  };
}

absl::StatusOr<std::unique_ptr<ScanReader>> MessageRecording::OpenAllScans(
    size_t topic, const ReadOptions& options) const {
  if (!(options.rate_hz > 0) || !std::isfinite(options.rate_hz)) {
    return absl::InvalidArgumentError("the rate must be positive");
  }
  const size_t index = scan_indices_[topic];
  const MessageTopic& messages = file_->topics()[index];
  const ScanMessage kind = *ScanMessageOf(messages);
  absl::StatusOr<std::unique_ptr<MessageReader>> reader = file_->OpenReader({index});
  if (!reader.ok()) return reader.status();
  if (kind != ScanMessage::kPackets && kind != ScanMessage::kOusterPackets) {
    return ReadClouds(messages, kind, *std::move(reader), options);
  }
  absl::StatusOr<DecoderMaker> maker = MakerOf(messages, kind, options);
  if (!maker.ok()) return maker.status();
  return ReadPackets(messages, *std::move(reader), options, *std::move(maker));
}

// Damaged parts are left out: the notes and the readers of scans report them.
absl::StatusOr<std::vector<GnssFix>> MessageRecording::ReadFixes(size_t gnss_topic) const {
  if (gnss_topic >= gnss_topics_.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("the recording has ", gnss_topics_.size(), " topics of fixes"));
  }
  const size_t index = gnss_indices_[gnss_topic];
  absl::StatusOr<std::unique_ptr<MessageReader>> reader = file_->OpenReader({index});
  if (!reader.ok()) return reader.status();
  std::vector<GnssFix> fixes;
  while (true) {
    absl::StatusOr<std::optional<Message>> message = (*reader)->Next();
    if (!message.ok()) continue;
    if (!message->has_value()) return fixes;
    absl::StatusOr<std::optional<GnssFix>> fix =
        DecodeNavSatFix(file_->topics()[index].encoding, (*message)->bytes, (*message)->log_ns);
    if (fix.ok() && fix->has_value()) fixes.push_back(**std::move(fix));
  }
}

absl::StatusOr<std::vector<StaticTransform>> MessageRecording::ReadStaticTransforms() const {
  std::map<std::pair<std::string, std::string>, StaticTransform> edges;
  absl::StatusOr<std::unique_ptr<MessageReader>> reader = file_->OpenReader(transform_indices_);
  if (!reader.ok()) return reader.status();
  while (true) {
    absl::StatusOr<std::optional<Message>> message = (*reader)->Next();
    if (!message.ok()) continue;
    if (!message->has_value()) break;
    const MessageTopic& topic = file_->topics()[(*message)->topic];
    absl::StatusOr<std::vector<StaticTransform>> transforms =
        DecodeTransforms(topic.encoding, (*message)->bytes);
    if (!transforms.ok()) {
      return absl::Status(transforms.status().code(),
                          absl::StrCat(topic.name, ": ", transforms.status().message()));
    }
    for (StaticTransform& edge : *transforms) {
      edges.insert_or_assign(std::pair(edge.parent, edge.child), std::move(edge));
    }
  }
  std::vector<StaticTransform> all;
  all.reserve(edges.size());
  for (auto& [names, edge] : edges) all.push_back(std::move(edge));
  return all;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Recording>> MakeMessageRecording(
    std::shared_ptr<const MessageFile> file, const std::string& path,
    const PacketDecoderFactories& factories) {
  std::string names;
  for (const MessageTopic& topic : file->topics()) {
    absl::StrAppend(&names, names.empty() ? "" : ", ", topic.name, " (", topic.type, ")");
  }
  auto recording = std::make_unique<MessageRecording>(std::move(file), path, factories);
  if (!recording->scan_topics().empty()) return recording;
  std::string notes;
  for (const std::string& note : recording->notes()) absl::StrAppend(&notes, "; ", note);
  return absl::NotFoundError(absl::StrCat(
      path,
      " holds no topic that scans can be read from: PointCloud2, CustomMsg, VelodyneScan, "
      "PandarScan, NebulaPackets, UdpFrame, PacketMsg or foxglove.PointCloud; it has ",
      names.empty() ? "none at all" : names, notes));
}

absl::StatusOr<std::unique_ptr<Recording>> OpenMessageRecording(
    const std::string& path, const PacketDecoderFactories& factories) {
  absl::StatusOr<std::shared_ptr<const MessageFile>> file = OpenMessageFile(path);
  if (!file.ok()) return file.status();
  return MakeMessageRecording(*std::move(file), path, factories);
}

}  // namespace isthmus::readers
