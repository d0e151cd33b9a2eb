// Long answers as streams of responses of bounded size: lists, and files.
#pragma once

#include <absl/status/status.h>
#include <google/protobuf/repeated_field.h>
#include <grpcpp/support/sync_stream.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "api/convert/graph.h"
#include "core/cloud.h"
#include "core/io/crc32c.h"
#include "core/map/match.h"
#include "server/rpc/call.h"

namespace isthmus::rpc {

// About what a response holds; gRPC's clients take 4 MiB unless told otherwise.
inline constexpr size_t kResponseBytes = 1 << 20;
// Points of the map in one.
inline constexpr size_t kResponsePoints = kResponseBytes / sizeof(MapPoint);

inline absl::Status ReaderGone() { return absl::CancelledError("the client stopped reading"); }

// Fills responses with the records of a list, for as long as the call may go on. Not thread safe.
template <typename Response>
class ListEmitter {
 public:
  // Each response begins as `head`: what all of them say.
  ListEmitter(const Call& call, Response head, grpc::ServerWriter<Response>* writer)
      : call_(call), head_(std::move(head)), writer_(*writer), response_(head_) {}

  // `field` is one of the response's accessors: &Response::mutable_submaps.
  template <typename Record>
  void Add(google::protobuf::RepeatedPtrField<Record>* (Response::*field)(), Record record) {
    if (!reading_) return;
    const size_t bytes = record.ByteSizeLong();
    if (bytes_ > 0 && bytes_ + bytes > kResponseBytes) Send();
    bytes_ += bytes;
    *(response_.*field)()->Add() = std::move(record);
  }

  // Ends the response under way, if it holds anything.
  void Break() {
    if (bytes_ > 0) Send();
  }
  // Sends what is left, and at least one response. Cancelled once the reader has gone away.
  absl::Status Finish() {
    if (bytes_ > 0 || sent_ == 0) Send();
    return reading_ ? absl::OkStatus() : ReaderGone();
  }

 private:
  void Send() {
    reading_ = reading_ && call_.Allowed().ok() && writer_.Write(response_);
    response_ = head_;
    bytes_ = 0;
    ++sent_;
  }

  const Call& call_;
  const Response head_;
  grpc::ServerWriter<Response>& writer_;
  Response response_;
  size_t bytes_ = 0;  // Size of its records.
  size_t sent_ = 0;
  bool reading_ = true;
};

// Adds a match or loop closure with the submaps that carry it; those beyond what one response has
// room for go into the responses that follow.
template <typename Response, typename Record>
void AddWithEdges(google::protobuf::RepeatedPtrField<Record>* (Response::*field)(), Record record,
                  const std::vector<SubmapEdge>& edges, ListEmitter<Response>* list) {
  constexpr size_t kTogether = 2000;  // A quarter of a kilobyte each.
  const size_t together = std::min(edges.size(), kTogether);
  for (size_t k = 0; k < together; ++k) *record.add_edges() = convert::ToMessage(edges[k]);
  list->Add(field, std::move(record));
  if (together < edges.size()) list->Break();
  for (size_t k = together; k < edges.size(); ++k) {
    list->Add(&Response::mutable_more_edges, convert::ToMessage(edges[k]));
  }
}

// Cuts a file into responses and sums it up in the last one. Every response names the revision.
// `Response` has data, revision, last, size and crc32c. Not thread safe.
template <typename Response>
class FileEmitter {
 public:
  FileEmitter(const Call& call, grpc::ServerWriter<Response>* writer)
      : call_(call), writer_(*writer) {}

  // Before the first piece.
  void SetRevision(int64_t revision) { response_.set_revision(revision); }

  // False once the reader has gone away, or the call must end.
  bool Add(const std::string& piece) {
    size_ += piece.size();
    crc32c_ = io::Crc32c(piece.data(), piece.size(), crc32c_);
    for (size_t offset = 0; offset < piece.size(); offset += kResponseBytes) {
      response_.set_data(piece.data() + offset, std::min(kResponseBytes, piece.size() - offset));
      if (!call_.Allowed().ok() || !writer_.Write(response_)) return false;
    }
    return true;
  }

  // Sends the last response: `last` with what is known of the whole file. Cancelled once the reader
  // has gone away.
  absl::Status Finish(Response last = {}) {
    last.set_revision(response_.revision());
    last.set_last(true);
    last.set_size(size_);
    last.set_crc32c(crc32c_);
    return writer_.Write(last) ? absl::OkStatus() : ReaderGone();
  }

 private:
  const Call& call_;
  grpc::ServerWriter<Response>& writer_;
  Response response_;
  uint64_t size_ = 0;
  uint32_t crc32c_ = 0;
};

}  // namespace isthmus::rpc
