#include "server/rpc/upload_submap.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "core/io/crc32c.h"
#include "core/io/sha256.h"

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
  auto begun = staging_.BeginUpload(KeyOf(header_), taken_over_);
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
  absl::StatusOr<std::string> data = part_->TakeData();
  if (!data.ok()) return data.status();
  absl::Status status = CheckContent(header_, *data);
  if (!status.ok()) {
    staging_.Drop(KeyOf(header_).id);
    return status;
  }
  header_.mutable_cloud()->set_data(*std::move(data));
  return std::move(header_);
}

}  // namespace isthmus::rpc
