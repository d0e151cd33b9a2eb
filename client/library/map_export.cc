// The part of Client that fetches files: the map, and its pose graph.
#include <utility>

#include "api/convert/map.h"
#include "api/convert/map_name.h"
#include "client/library/client.h"
#include "client/library/file_stream.h"
#include "client/library/link.h"
#include "core/io/output_file.h"
#include "core/io/output_name.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

namespace {

using Bytes = FilePiece;
// One attempt at a file; the summary counts what was handed to the bytes.
using Fetch = std::function<absl::Status(const Bytes&, ExportSummary&)>;

Fetch FetchMap(Client::Link& link, const ExportRequest& request) {
  return
      [&link, message = convert::ToMessage(request)](const Bytes& bytes, ExportSummary& summary) {
        const auto open = [&message](Stubs& stubs, grpc::ClientContext& context) {
          return stubs.maps->ExportMap(&context, message);
        };
        return FetchStream<v1::ExportMapResponse>(link, open, bytes, summary,
                                                  link.options().max_file_bytes);
      };
}

Fetch FetchPoseGraph(Client::Link& link, const MapName& map) {
  v1::ExportPoseGraphRequest request;
  convert::PutMap(map, request);
  return [&link, message = std::move(request)](const Bytes& bytes, ExportSummary& summary) {
    const auto open = [&message](Stubs& stubs, grpc::ClientContext& context) {
      return stubs.maps->ExportPoseGraph(&context, message);
    };
    return FetchStream<v1::ExportPoseGraphResponse>(link, open, bytes, summary,
                                                    link.options().max_file_bytes);
  };
}

// Again and again until it is whole; a stream cannot be begun again once it has bytes.
absl::StatusOr<ExportSummary> ToFile(Client::Link& link, const Fetch& fetch,
                                     const std::string& path,
                                     const std::function<void(uint64_t)>& progress) {
  if (absl::Status status = io::CheckOutput(path); !status.ok()) return status;
  io::OutputFile file(path);
  ExportSummary summary;
  absl::Status status = link.Repeat(true, [&] {
    absl::Status written = file.Open();
    if (!written.ok()) return NotAgain(written);
    const auto append = [&](const std::string& bytes) {
      written = file.Append(bytes);
      if (progress) progress(summary.size);
      return written.ok();
    };
    const absl::Status fetched = fetch(append, summary);
    if (!written.ok()) return NotAgain(written);
    return file.is_stream() && summary.size > 0 ? NotAgain(fetched) : fetched;
  });
  if (status.ok()) status = file.Commit();
  if (!status.ok()) return status;
  return summary;
}

const char* ExtensionOf(ExportFormat format) {
  switch (format) {
    case ExportFormat::kPly:
      return ".ply";
    case ExportFormat::kOctoMapBinary:
      return ".bt";
    case ExportFormat::kOctoMapFull:
      return ".ot";
    default:
      return ".pcd";
  }
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
  const absl::Status named = io::CheckOutputName(path, {ExtensionOf(request.format)});
  if (!named.ok()) return named;
  return ToFile(*link_, FetchMap(*link_, request), path, progress);
}

absl::StatusOr<ExportSummary> Client::ExportPoseGraphToFile(const MapName& map,
                                                            const std::string& path) {
  if (absl::Status named = io::CheckOutputName(path, {".g2o"}); !named.ok()) return named;
  return ToFile(*link_, FetchPoseGraph(*link_, map), path, nullptr);
}

}  // namespace isthmus::client
