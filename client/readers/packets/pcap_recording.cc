#include "client/readers/packets/pcap_recording.h"

#include <absl/strings/str_cat.h>

#include <cerrno>
#include <utility>

#include "client/readers/packets/capture/pcap_file.h"
#include "client/readers/packets/capture/survey.h"
#include "client/readers/packets/maker.h"
#include "client/readers/packets/packet_decoder.h"
#include "core/io/file_io.h"

namespace isthmus::readers {
namespace {

using capture::PcapFile;
using capture::ReceiverStream;
using capture::SensorStream;
using capture::Stream;

class PcapScanReader : public ScanReader {
 public:
  PcapScanReader(std::unique_ptr<PcapFile> file, std::unique_ptr<PacketDecoder> decoder,
                 Stream stream)
      : file_(std::move(file)), decoder_(std::move(decoder)), stream_(stream) {}

  absl::StatusOr<std::optional<RecordedScan>> Next() override {
    while (true) {
      if (ready_ < scans_.size()) {
        RecordedScan scan = std::move(scans_[ready_++]);
        absl::StrAppend(&scan.name, " of ", stream_.Name());
        return scan;
      }
      scans_.clear();
      ready_ = 0;
      if (ended_) return End();
      if (const absl::Status status = ReadPacket(); !status.ok()) return status;
    }
  }

  std::string sensor() const override { return decoder_->sensor(); }
  std::vector<std::string> Assumptions() const override { return decoder_->Assumptions(); }

 private:
  // An error ends the recording.
  absl::Status ReadPacket() {
    const std::optional<PcapFile::Arrived> arrived = file_->Next();
    if (!arrived) {
      ended_ = true;
      decoder_->Flush(&scans_);
      return absl::OkStatus();
    }
    if (!stream_.Has(arrived->datagram)) return absl::OkStatus();
    const absl::Status status =
        decoder_->Add(arrived->datagram.payload, arrived->arrival_ns, &scans_);
    if (absl::IsFailedPrecondition(status)) {
      ended_ = told_ = true;
      return status;
    }
    if (!status.ok() && skipped_++ == 0) first_skipped_ = std::string(status.message());
    return absl::OkStatus();
  }

  // An error for the parts that could not be read, once; then empty: there is no more.
  absl::StatusOr<std::optional<RecordedScan>> End() {
    std::string trouble = file_->Damage();
    if (skipped_ > 0) {
      absl::StrAppend(&trouble, trouble.empty() ? "" : "; ", skipped_, " packets of ",
                      stream_.Name(), " were skipped: ", first_skipped_);
    }
    if (trouble.empty() || std::exchange(told_, true)) return std::nullopt;
    return absl::DataLossError(trouble);
  }

  std::unique_ptr<PcapFile> file_;
  std::unique_ptr<PacketDecoder> decoder_;
  const Stream stream_;
  std::vector<RecordedScan> scans_;  // From ready_ on: to be given.
  size_t ready_ = 0;
  bool ended_ = false, told_ = false;
  uint64_t skipped_ = 0;
  std::string first_skipped_;
};

using OpenFile = std::function<absl::StatusOr<std::unique_ptr<PcapFile>>()>;

class PcapRecording : public Recording {
 public:
  PcapRecording(std::string path, OpenFile open, capture::Survey survey)
      : path_(std::move(path)), open_(std::move(open)), survey_(std::move(survey)) {
    for (const SensorStream& sensor : survey_.sensors) {
      topics_.push_back({sensor.stream.Name(), PacketsOf(sensor.maker), sensor.packets});
    }
  }

  std::string kind() const override { return "capture of packets"; }
  const std::vector<ScanTopic>& scan_topics() const override { return topics_; }
  std::vector<std::string> notes() const override { return survey_.notes; }

  std::vector<GnssTopic> gnss_topics() const override {
    std::vector<GnssTopic> topics;
    for (const ReceiverStream& receiver : survey_.receivers) {
      topics.push_back({receiver.stream.Name(), receiver.packets});
    }
    return topics;
  }
  absl::StatusOr<std::vector<GnssFix>> ReadFixes(size_t gnss_topic) const override {
    if (gnss_topic >= survey_.receivers.size()) {
      return absl::InvalidArgumentError(absl::StrCat(path_, " has no such topic of fixes"));
    }
    absl::StatusOr<std::unique_ptr<PcapFile>> file = open_();
    if (!file.ok()) return file.status();
    return capture::FixesOf(**file, survey_.receivers[gnss_topic].stream);
  }

 private:
  absl::StatusOr<std::unique_ptr<ScanReader>> OpenAllScans(
      size_t topic, const ReadOptions& options) const override;
  // The receiver's that is connected to the sensor: its packets come from the same address.
  std::optional<int64_t> UtcOffsetOf(const SensorStream& sensor) const {
    for (const ReceiverStream& receiver : survey_.receivers) {
      if (receiver.stream.source == sensor.stream.source) return receiver.utc_offset_ns;
    }
    return std::nullopt;
  }

  const std::string path_;
  const OpenFile open_;
  const capture::Survey survey_;
  std::vector<ScanTopic> topics_;
};

absl::StatusOr<std::unique_ptr<ScanReader>> PcapRecording::OpenAllScans(
    size_t topic, const ReadOptions& options) const {
  const SensorStream& sensor = survey_.sensors[topic];
  const bool needs_calibration = sensor.model == velodyne::Model::kHdl64;
  ReadOptions with_model = options;
  if (needs_calibration && options.sensor.empty()) with_model.sensor = "hdl64";
  absl::StatusOr<std::unique_ptr<PacketDecoder>> decoder =
      MakeDecoder(sensor.maker, with_model, UtcOffsetOf(sensor), path_, sensor.packet_bytes);
  if (!decoder.ok()) return decoder.status();
  if (!sensor.angles.empty()) {
    std::vector<RecordedScan> none;
    if (const absl::Status status = (*decoder)->Add(sensor.angles, 0, &none); !status.ok()) {
      return status;
    }
  }
  absl::StatusOr<std::unique_ptr<PcapFile>> file = open_();
  if (!file.ok()) return file.status();
  return std::make_unique<PcapScanReader>(*std::move(file), *std::move(decoder), sensor.stream);
}

absl::StatusOr<std::unique_ptr<Recording>> OpenWith(const std::string& path, OpenFile open) {
  const absl::StatusOr<std::unique_ptr<PcapFile>> file = open();
  if (!file.ok()) return file.status();
  capture::Survey survey = capture::SurveyOf(**file);
  if (survey.sensors.empty()) {
    std::string what;
    for (const std::string& note : survey.notes) absl::StrAppend(&what, "; ", note);
    return absl::NotFoundError(absl::StrCat(path, " holds no point data of ", kKnownMakers, what));
  }
  return std::make_unique<PcapRecording>(path, std::move(open), std::move(survey));
}

}  // namespace

absl::StatusOr<std::unique_ptr<Recording>> OpenPcapRecording(const std::string& path) {
  return OpenWith(path, [path] { return PcapFile::Open(path); });
}

absl::StatusOr<std::unique_ptr<Recording>> OpenPcapRecording(const std::string& path,
                                                             std::function<FILE*()> open) {
  return OpenWith(path, [path, open]() -> absl::StatusOr<std::unique_ptr<PcapFile>> {
    FILE* stream = open();
    if (stream == nullptr) return io::FileError("open", path, errno);
    return PcapFile::Open(stream, path);
  });
}

}  // namespace isthmus::readers
