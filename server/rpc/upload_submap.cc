#include "server/rpc/upload_submap.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "core/codec/crc32c.h"
#include "server/rpc/submap_conversion.h"

namespace isthmus::rpc {

absl::Status SubmapReceiver::Add(v1::UploadSubmapRequest&& part) {
  if (part.has_header() == has_header_) {
    return absl::InvalidArgumentError(has_header_
                                          ? "a second header: one upload carries one submap"
                                          : "the first message of an upload must be its header");
  }
  if (has_header_) return AddChunk(part.chunk());
  has_header_ = true;
  header_ = std::move(*part.mutable_header());
  if (header_.size() > max_bytes_) {
    return absl::ResourceExhaustedError(
        absl::StrCat("a submap of ", header_.size(), " bytes is larger than the server takes (",
                     max_bytes_, "): thin it out, or cut smaller submaps"));
  }
  return absl::OkStatus();
}

absl::Status SubmapReceiver::AddChunk(const v1::UploadSubmapChunk& chunk) {
  if (chunk.offset() != data_.size()) {
    return absl::OutOfRangeError(absl::StrCat("chunk at offset ", chunk.offset(), " but offset ",
                                              data_.size(), " is expected next"));
  }
  if (chunk.data().size() > header_.size() - data_.size()) {
    return absl::OutOfRangeError(absl::StrCat("chunk at offset ", chunk.offset(),
                                              " runs past the size of ", header_.size(),
                                              " bytes given in the header"));
  }
  data_ += chunk.data();
  return absl::OkStatus();
}

absl::StatusOr<v1::UploadSubmapHeader> SubmapReceiver::Finish() {
  if (!has_header_) {
    return absl::InvalidArgumentError("the upload ended before its header");
  }
  if (data_.size() != header_.size()) {
    return absl::DataLossError(absl::StrCat("the upload ended after ", data_.size(), " of ",
                                            header_.size(), " bytes: send it again"));
  }
  if (const uint32_t crc32c = codec::Crc32c(data_.data(), data_.size());
      crc32c != header_.crc32c()) {
    return absl::DataLossError(absl::StrCat("the bytes have crc32c ", crc32c,
                                            " but the header says ", header_.crc32c(),
                                            ": send it again"));
  }
  header_.mutable_cloud()->set_data(std::move(data_));
  return std::move(header_);
}

absl::StatusOr<v1::UploadSubmapResponse> UploadSubmap(server::Pipeline& pipeline,
                                                      uint64_t max_bytes, const ReadPart& read) {
  SubmapReceiver receiver(max_bytes);
  v1::UploadSubmapRequest part;
  RobotId robot;
  while (read(&part)) {
    if (absl::Status status = receiver.Add(std::move(part)); !status.ok()) return status;
    if (!robot.empty()) continue;
    // Asked before the bytes come, so that a wrong name costs nothing.
    const auto session = pipeline.GetSession(SessionId(receiver.header().session()));
    if (!session.ok()) return session.status();
    robot = session->record.robot;
  }
  auto header = receiver.Finish();
  if (!header.ok()) return header.status();
  auto submap = ToSubmap(*std::move(header), robot);
  if (!submap.ok()) return submap.status();
  const auto info = pipeline.AddSubmap(*std::move(submap));
  if (!info.ok()) return info.status();
  v1::UploadSubmapResponse response;
  response.set_session(info->id.session.value());
  response.set_index(info->id.index);
  response.set_point_count(info->point_count);
  return response;
}

}  // namespace isthmus::rpc
