// The part of Client that sends a finished submap.
#include <algorithm>

#include "client/library/client.h"
#include "client/library/convert.h"
#include "client/library/link.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

namespace {

constexpr size_t kChunkBytes = 1 << 20;

grpc::Status Send(Stubs& stubs, grpc::ClientContext& context, const v1::UploadSubmapHeader& header,
                  const std::string& data) {
  v1::UploadSubmapResponse response;
  auto writer = stubs.sessions->UploadSubmap(&context, &response);
  v1::UploadSubmapRequest request;
  *request.mutable_header() = header;
  bool open = writer->Write(request);
  for (size_t offset = 0; open && offset < data.size(); offset += kChunkBytes) {
    v1::UploadSubmapChunk* chunk = request.mutable_chunk();
    chunk->set_offset(offset);
    chunk->set_data(data.data() + offset, std::min(kChunkBytes, data.size() - offset));
    open = writer->Write(request);
  }
  writer->WritesDone();
  return writer->Finish();  // Says why the server closed the stream early, if it did.
}

}  // namespace

absl::Status Client::UploadSubmap(const SubmapUpload& submap) {
  const v1::UploadSubmapHeader header = ToProto(submap);
  return link_->Repeat(true, [&] {
    return link_->Once(link_->options().transfer_timeout_s,
                       [&](Stubs& stubs, grpc::ClientContext& context) {
                         return Send(stubs, context, header, submap.cloud.data);
                       });
  });
}

}  // namespace isthmus::client
