// Files that the server streams, and whether they arrived whole. Private to the library.
#pragma once

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <functional>
#include <string>

#include "client/library/answer_bound.h"
#include "client/library/link.h"
#include "client/library/transfers.h"
#include "core/io/crc32c.h"

namespace isthmus::client {

// Takes a piece; false stops the stream.
using FilePiece = std::function<bool(const std::string&)>;

// Compares what arrived with what the server says it sent.
template <typename Response>
absl::Status VerifyFile(const ExportSummary& received, const Response& last) {
  if (!last.last()) return absl::DataLossError("the file ended early; run it again");
  if (received.size == last.size() && received.crc32c == last.crc32c()) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrCat("the file was damaged on its way: ", received.size, " bytes with checksum ",
                   absl::Hex(received.crc32c, absl::kZeroPad8), " arrived, ", last.size(), " with ",
                   absl::Hex(last.crc32c(), absl::kZeroPad8), " were sent; run it again"));
}

// One attempt at a file. `open` begins the stream and returns its reader; `note`, if any, sees
// every response, and `summary` counts what was handed to `bytes`. Cancelled when that stopped it,
// ResourceExhausted where there are more than `most` bytes.
template <typename Response, typename Open>
absl::Status FetchStream(Client::Link& link, const Open& open, const FilePiece& bytes,
                         ExportSummary& summary, uint64_t most,
                         const std::function<void(const Response&)>& note = nullptr) {
  summary = {};
  absl::Status failure;  // Found on this side.
  const auto read = [&](Client::Link::Stubs& stubs, grpc::ClientContext& context) {
    auto reader = open(stubs, context);
    AnswerBound bound(most);
    Response part;
    while (failure.ok() && reader->Read(&part)) {
      if (note) note(part);
      failure = bound.Add(part.data().size());
      if (!failure.ok()) {
        context.TryCancel();
        break;
      }
      summary.revision = part.revision();
      summary.size += part.data().size();
      summary.crc32c = io::Crc32c(part.data().data(), part.data().size(), summary.crc32c);
      if (part.data().empty() || bytes(part.data())) continue;
      failure = absl::CancelledError("stopped by the reader");
      context.TryCancel();
    }
    const grpc::Status status = reader->Finish();
    if (failure.ok() && status.ok()) failure = VerifyFile(summary, part);
    return status;
  };
  const absl::Status status = link.Once(link.options().transfer_timeout_s, read);
  return failure.ok() ? status : failure;
}

}  // namespace isthmus::client
