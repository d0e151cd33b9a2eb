// The part of Client that fetches files: the map, and its pose graph.
#include <absl/strings/str_cat.h>

#include <utility>

#include "client/library/client.h"
#include "client/library/convert.h"
#include "client/library/link.h"
#include "client/library/part_file.h"
#include "core/codec/crc32c.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

namespace {

using Bytes = std::function<bool(const std::string&)>;
// One attempt at a file; the summary counts what was handed to the bytes.
using Fetch = std::function<absl::Status(const Bytes&, ExportSummary&)>;

// Compares what arrived with what the server says it sent.
template <typename Response>
absl::Status Verify(const ExportSummary& received, const Response& last) {
  if (!last.last()) return absl::DataLossError("the export ended early; run it again");
  if (received.size == last.size() && received.crc32c == last.crc32c()) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrCat("the export was damaged on its way: ", received.size, " bytes with checksum ",
                   absl::Hex(received.crc32c, absl::kZeroPad8), " arrived, ", last.size(), " with ",
                   absl::Hex(last.crc32c(), absl::kZeroPad8), " were sent; run it again"));
}

// `open` begins the stream and returns its reader.
template <typename Response, typename Open>
absl::Status FetchStream(Client::Link& link, const Open& open, const Bytes& bytes,
                         ExportSummary& summary) {
  summary = {};
  absl::Status failure;  // Found on this side.
  const auto read = [&](Stubs& stubs, grpc::ClientContext& context) {
    auto reader = open(stubs, context);
    Response part;
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

Fetch FetchMap(Client::Link& link, const ExportRequest& request) {
  return [&link, message = ToProto(request)](const Bytes& bytes, ExportSummary& summary) {
    const auto open = [&message](Stubs& stubs, grpc::ClientContext& context) {
      return stubs.maps->ExportMap(&context, message);
    };
    return FetchStream<v1::ExportMapResponse>(link, open, bytes, summary);
  };
}

Fetch FetchPoseGraph(Client::Link& link, uint32_t component) {
  v1::ExportPoseGraphRequest request;
  request.set_component(component);
  return [&link, message = std::move(request)](const Bytes& bytes, ExportSummary& summary) {
    const auto open = [&message](Stubs& stubs, grpc::ClientContext& context) {
      return stubs.graph->ExportPoseGraph(&context, message);
    };
    return FetchStream<v1::ExportPoseGraphResponse>(link, open, bytes, summary);
  };
}

// Into PATH.part, again and again until it is whole, then PATH.
absl::StatusOr<ExportSummary> ToFile(Client::Link& link, const Fetch& fetch,
                                     const std::string& path,
                                     const std::function<void(uint64_t)>& progress) {
  PartFile file(path);
  ExportSummary summary;
  absl::Status status = link.Repeat(true, [&] {
    absl::Status written = file.Open();
    if (!written.ok()) return written;
    const auto append = [&](const std::string& bytes) {
      written = file.Append(bytes);
      if (progress) progress(summary.size);
      return written.ok();
    };
    const absl::Status fetched = fetch(append, summary);
    return written.ok() ? fetched : written;
  });
  if (status.ok()) status = file.Commit();
  if (!status.ok()) return status;
  return summary;
}

}  // namespace

absl::StatusOr<ExportSummary> Client::Export(const ExportRequest& request, const Bytes& bytes) {
  const Fetch fetch = FetchMap(*link_, request);
  ExportSummary summary;
  const absl::Status status = link_->Repeat(false, [&] {
    const absl::Status fetched = fetch(bytes, summary);
    return summary.size > 0 ? NotAgain(fetched) : fetched;
  });
  if (!status.ok()) return status;
  return summary;
}

absl::StatusOr<ExportSummary> Client::ExportToFile(const ExportRequest& request,
                                                   const std::string& path,
                                                   const std::function<void(uint64_t)>& progress) {
  return ToFile(*link_, FetchMap(*link_, request), path, progress);
}

absl::StatusOr<ExportSummary> Client::ExportPoseGraphToFile(uint32_t component,
                                                            const std::string& path) {
  return ToFile(*link_, FetchPoseGraph(*link_, component), path, nullptr);
}

}  // namespace isthmus::client
