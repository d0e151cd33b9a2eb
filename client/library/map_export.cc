// The part of Client that fetches the map as a file.
#include <absl/strings/str_cat.h>

#include "client/library/client.h"
#include "client/library/convert.h"
#include "client/library/link.h"
#include "client/library/part_file.h"
#include "core/codec/crc32c.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

namespace {

// Compares what arrived with what the server says it sent.
absl::Status Verify(const ExportSummary& received, const v1::ExportMapResponse& last) {
  if (!last.last()) return absl::DataLossError("the export ended early; run it again");
  if (received.size == last.size() && received.crc32c == last.crc32c()) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrCat("the export was damaged on its way: ", received.size, " bytes with checksum ",
                   absl::Hex(received.crc32c, absl::kZeroPad8), " arrived, ", last.size(), " with ",
                   absl::Hex(last.crc32c(), absl::kZeroPad8), " were sent; run it again"));
}

// One attempt; `summary` counts what was handed to `bytes`.
absl::Status Fetch(Client::Link& link, const ExportRequest& request,
                   const std::function<bool(const std::string&)>& bytes, ExportSummary& summary) {
  summary = {};
  absl::Status failure;  // Found on this side.
  const auto read = [&](Stubs& stubs, grpc::ClientContext& context) {
    auto reader = stubs.maps->ExportMap(&context, ToProto(request));
    v1::ExportMapResponse part;
    while (failure.ok() && reader->Read(&part)) {
      summary.revision = part.revision();
      summary.size += part.data().size();
      summary.crc32c = codec::Crc32c(part.data().data(), part.data().size(), summary.crc32c);
      if (part.data().empty() || bytes(part.data())) continue;
      failure = absl::CancelledError("stopped by the reader");
      context.TryCancel();
    }
    const grpc::Status status = reader->Finish();
    if (failure.ok() && status.ok()) failure = Verify(summary, part);
    return status;
  };
  const absl::Status status = link.Once(link.options().transfer_timeout_s, read);
  return failure.ok() ? status : failure;
}

}  // namespace

absl::StatusOr<ExportSummary> Client::Export(const ExportRequest& request,
                                             const std::function<bool(const std::string&)>& bytes) {
  ExportSummary summary;
  const absl::Status status = link_->Repeat(false, [&] {
    const absl::Status fetched = Fetch(*link_, request, bytes, summary);
    return summary.size > 0 ? NotAgain(fetched) : fetched;
  });
  if (!status.ok()) return status;
  return summary;
}

absl::StatusOr<ExportSummary> Client::ExportToFile(const ExportRequest& request,
                                                   const std::string& path,
                                                   const std::function<void(uint64_t)>& progress) {
  PartFile file(path);
  ExportSummary summary;
  absl::Status status = link_->Repeat(true, [&] {
    absl::Status written = file.Open();
    if (!written.ok()) return written;
    const absl::Status fetched = Fetch(
        *link_, request,
        [&](const std::string& bytes) {
          written = file.Append(bytes);
          if (progress) progress(summary.size);
          return written.ok();
        },
        summary);
    return written.ok() ? fetched : written;
  });
  if (status.ok()) status = file.Commit();
  if (!status.ok()) return status;
  return summary;
}

}  // namespace isthmus::client
