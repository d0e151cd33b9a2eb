#include "server/rpc/upload_submap.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "core/io/crc32c.h"
#include "core/io/sha256.h"
#include "server/rpc/submap_conversion.h"

namespace isthmus::rpc {
namespace {

UploadKey KeyOf(const v1::UploadSubmapHeader& header) {
  return {{SessionId(header.session()), header.index()},
          header.size(),
          header.crc32c(),
          header.sha256()};
}

absl::Status CheckContent(const v1::UploadSubmapHeader& header, const std::string& data) {
  if (const uint32_t crc32c = io::Crc32c(data.data(), data.size()); crc32c != header.crc32c()) {
    return absl::DataLossError(absl::StrCat("the bytes have crc32c ", crc32c,
                                            " but the header says ", header.crc32c(),
                                            ": send it again"));
  }
  if (!header.sha256().empty() && io::Sha256(data.data(), data.size()) != header.sha256()) {
    return absl::DataLossError("the bytes have another sha256 than the header says: send it again");
  }
  return absl::OkStatus();
}

}  // namespace

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
  auto begun = staging_.Begin(KeyOf(header_));
  if (!begun.ok()) return begun.status();
  part_ = *std::move(begun);
  return absl::OkStatus();
}

absl::Status SubmapReceiver::AddChunk(const v1::UploadSubmapChunk& chunk) {
  // One that was sent before takes the place of what was there, and of all behind it.
  if (chunk.offset() > part_->size()) {
    return absl::OutOfRangeError(absl::StrCat("chunk at offset ", chunk.offset(), " but offset ",
                                              part_->size(), " is expected next"));
  }
  if (chunk.data().size() > header_.size() - chunk.offset()) {
    return absl::OutOfRangeError(absl::StrCat("chunk at offset ", chunk.offset(),
                                              " runs past the size of ", header_.size(),
                                              " bytes given in the header"));
  }
  return part_->Append(chunk.offset(), chunk.data());
}

absl::StatusOr<v1::UploadSubmapHeader> SubmapReceiver::Finish() {
  if (!has_header_) {
    return absl::InvalidArgumentError("the upload ended before its header");
  }
  if (part_->size() != header_.size()) {
    return absl::DataLossError(absl::StrCat("the upload ended after ", part_->size(), " of ",
                                            header_.size(), " bytes: send the rest"));
  }
  std::string data = part_->TakeData();
  absl::Status status = CheckContent(header_, data);
  if (!status.ok()) {
    staging_.Drop(KeyOf(header_).id);
    return status;
  }
  header_.mutable_cloud()->set_data(std::move(data));
  return std::move(header_);
}

absl::StatusOr<v1::UploadSubmapResponse> UploadSubmap(server::Pipeline& pipeline,
                                                      UploadStaging& staging, uint64_t max_bytes,
                                                      const ReadPart& read) {
  SubmapReceiver receiver(max_bytes, staging);
  v1::UploadSubmapRequest part;
  RobotId robot;
  while (read(&part)) {
    if (robot.empty() && part.has_header()) {
      // Asked before the bytes come, so that a wrong name costs nothing.
      const auto session = pipeline.GetSession(SessionId(part.header().session()));
      if (!session.ok()) return session.status();
      robot = session->record.robot;
    }
    if (absl::Status status = receiver.Add(std::move(part)); !status.ok()) return status;
  }
  auto header = receiver.Finish();
  if (!header.ok()) return header.status();
  const SubmapId id = KeyOf(*header).id;
  auto submap = ToSubmap(*std::move(header), robot);
  absl::StatusOr<SubmapInfo> info =
      submap.ok() ? pipeline.AddSubmap(*std::move(submap)) : submap.status();
  // An upload that fails for a while need not travel again.
  const bool may_come = absl::IsUnavailable(info.status()) ||
                        absl::IsResourceExhausted(info.status()) ||
                        absl::IsOutOfRange(info.status());
  if (!may_come) staging.Drop(id);
  if (!info.ok()) return info.status();
  v1::UploadSubmapResponse response;
  response.set_session(info->id.session.value());
  response.set_index(info->id.index);
  response.set_point_count(info->point_count);
  return response;
}

absl::StatusOr<v1::GetUploadResponse> GetUpload(server::Pipeline& pipeline, UploadStaging& staging,
                                                const v1::GetUploadRequest& request) {
  const SessionId session(request.session());
  if (const auto known = pipeline.GetSession(session); !known.ok()) return known.status();
  v1::GetUploadResponse response;
  response.set_persisted(staging.Persisted(
      {{session, request.index()}, request.size(), request.crc32c(), request.sha256()}));
  return response;
}

}  // namespace isthmus::rpc
