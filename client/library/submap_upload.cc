// The part of Client that sends a finished submap.
#include <algorithm>

#include "api/convert/session.h"
#include "client/library/client.h"
#include "client/library/link.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

namespace {

constexpr size_t kChunkBytes = 1 << 20;

// Bytes of it that the server has; 0 if it cannot say.
uint64_t AskPersisted(Client::Link& link, const v1::UploadSubmapHeader& header) {
  v1::GetUploadRequest request;
  request.set_session(header.session());
  request.set_index(header.index());
  request.set_size(header.size());
  request.set_crc32c(header.crc32c());
  request.set_sha256(header.sha256());
  v1::GetUploadResponse response;
  const absl::Status status =
      link.Once(link.options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.sessions->GetUpload(&context, request, &response);
      });
  return status.ok() ? std::min(response.persisted(), header.size()) : 0;
}

grpc::Status Send(Stubs& stubs, grpc::ClientContext& context, const v1::UploadSubmapHeader& header,
                  const std::string& data, uint64_t from) {
  v1::UploadSubmapResponse response;
  auto writer = stubs.sessions->UploadSubmap(&context, &response);
  v1::UploadSubmapRequest request;
  *request.mutable_header() = header;
  bool open = writer->Write(request);
  for (size_t offset = from; open && offset < data.size(); offset += kChunkBytes) {
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
  const v1::UploadSubmapHeader header = convert::ToMessage(submap);
  return link_->Repeat(true, [&] {
    const uint64_t from = AskPersisted(*link_, header);
    return link_->Once(link_->options().transfer_timeout_s,
                       [&](Stubs& stubs, grpc::ClientContext& context) {
                         return Send(stubs, context, header, submap.cloud.data, from);
                       });
  });
}

}  // namespace isthmus::client
