// A server over a real socket that fails as told; the client must survive that. The real server is
// tested with the client in client_test.cc.
#pragma once

#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/concurrency/mutex.h"
#include "core/io/crc32c.h"
#include "isthmus/v1/edit_service.grpc.pb.h"
#include "isthmus/v1/map_service.grpc.pb.h"
#include "isthmus/v1/session_service.grpc.pb.h"

namespace isthmus::client {

// One session, "alice-1". Keeps sequences only.
class FakeSessions final : public v1::SessionService::Service {
 public:
  std::atomic<int> break_after{-1};      // Ends the stream after so many scans, once.
  std::atomic<int> swallow_acks{0};      // Number of acknowledgements lost before the break.
  std::atomic<int> forget_from{0};       // With the break: scans from here on are lost in a crash.
  std::atomic<int> forget_at_finish{0};  // The same when the session is to be finished, once.
  std::atomic<bool> hangs_at_finish{false}, stops_at_finish{false};  // The latter once.
  std::atomic<int> spoil_uploads{0};           // So many uploads end in DATA_LOSS.
  std::atomic<uint32_t> quantized_version{0};  // The version that it says it reads.
  std::atomic<int64_t> created_ns{1};
  // So many scans of other programs are in the session, once it was asked for, or with the break.
  std::atomic<uint64_t> taken_up{0}, others_at_break{0};
  std::atomic<int> creations{0}, uploads{0}, finishes{0};

  std::vector<uint64_t> effects() {
    MutexLock lock(&mutex_);
    return effects_;
  }

  v1::PointCloud last_cloud() {
    MutexLock lock(&mutex_);
    return last_cloud_;
  }

  grpc::Status CreateSession(grpc::ServerContext*, const v1::CreateSessionRequest* request,
                             v1::Session* session) override {
    ++creations;
    session->set_id(request->robot() + "-1");
    return grpc::Status::OK;
  }

  grpc::Status GetSession(grpc::ServerContext*, const v1::GetSessionRequest* request,
                          v1::Session* session) override {
    if (request->session() != "alice-1") return {grpc::StatusCode::NOT_FOUND, "no such session"};
    MutexLock lock(&mutex_);
    session->set_id("alice-1");
    session->set_quantized_version(quantized_version);
    session->set_created_ns(created_ns);
    session->set_last_sequence(last());
    if (taken_up > 0) others_ = taken_up.exchange(0);
    return grpc::Status::OK;
  }

  grpc::Status FinishSession(grpc::ServerContext* context, const v1::FinishSessionRequest* request,
                             v1::Session* session) override {
    while (hangs_at_finish && !context->IsCancelled()) std::this_thread::yield();
    if (stops_at_finish.exchange(false)) return {grpc::StatusCode::CANCELLED, "going down"};
    MutexLock lock(&mutex_);
    if (const int from = forget_at_finish.exchange(0); from > 0) {
      effects_.resize(from - 1);
      return {grpc::StatusCode::UNAVAILABLE, "killed on purpose"};
    }
    if (last() < request->last_sequence()) return {grpc::StatusCode::ABORTED, "send the rest"};
    ++finishes;
    session->set_id("alice-1");
    session->set_durable_sequence(last());
    return grpc::Status::OK;
  }

  grpc::Status StreamScans(
      grpc::ServerContext*,
      grpc::ServerReaderWriter<v1::StreamScansResponse, v1::StreamScansRequest>* stream) override {
    v1::StreamScansRequest request;
    while (stream->Read(&request)) {
      if (!request.has_scan()) continue;
      v1::StreamScansResponse ack;
      Keep(request.scan().cloud());
      const grpc::Status status = Take(request.scan().sequence(), ack);
      if (!status.ok()) return status;
      const bool breaks = break_after > 0 && --break_after == 0;
      if (!(break_after >= 0 && break_after < swallow_acks)) stream->Write(ack);
      if (breaks) return Break();
    }
    return grpc::Status::OK;
  }

  grpc::Status UploadSubmap(grpc::ServerContext*,
                            grpc::ServerReader<v1::UploadSubmapRequest>* reader,
                            v1::UploadSubmapResponse*) override {
    ++uploads;
    v1::UploadSubmapRequest request;
    reader->Read(&request);
    const v1::UploadSubmapHeader header = request.header();
    std::string data;
    while (reader->Read(&request)) {
      if (request.chunk().offset() != data.size()) return {grpc::StatusCode::OUT_OF_RANGE, "gap"};
      data += request.chunk().data();
    }
    if (spoil_uploads > 0) {
      --spoil_uploads;
      data[0] ^= 1;
    }
    if (data.size() != header.size() || io::Crc32c(data.data(), data.size()) != header.crc32c()) {
      return {grpc::StatusCode::DATA_LOSS, "crc32c differs"};
    }
    return grpc::Status::OK;
  }

 private:
  void Keep(const v1::PointCloud& cloud) {
    MutexLock lock(&mutex_);
    last_cloud_ = cloud;
  }

  grpc::Status Take(uint64_t sequence, v1::StreamScansResponse& ack) {
    MutexLock lock(&mutex_);
    if (sequence > last() + 1) return {grpc::StatusCode::OUT_OF_RANGE, "a sequence was left out"};
    ack.set_sequence(sequence);
    ack.set_outcome(sequence <= last() ? v1::StreamScansResponse::DUPLICATE
                                       : v1::StreamScansResponse::PROCESSED);
    if (sequence == last() + 1) effects_.push_back(sequence);
    return grpc::Status::OK;
  }

  uint64_t last() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return effects_.empty() ? others_ : std::max(effects_.back(), others_);
  }

  grpc::Status Break() {
    MutexLock lock(&mutex_);
    break_after = -1;
    if (forget_from > 0) effects_.resize(forget_from - 1);
    if (others_at_break > 0) others_ = others_at_break;
    return {grpc::StatusCode::UNAVAILABLE, "broken on purpose"};
  }

  Mutex mutex_;
  v1::PointCloud last_cloud_ ABSL_GUARDED_BY(mutex_);
  uint64_t others_ ABSL_GUARDED_BY(mutex_) = 0;
  std::vector<uint64_t> effects_ ABSL_GUARDED_BY(mutex_);  // Every scan that took effect, in order.
};

// A map that can be exported, whole or damaged.
class FakeMap final : public v1::MapService::Service {
 public:
  std::string file = std::string(3'000'000, 'm');
  std::atomic<int> damaged{0};      // So many exports arrive with a byte changed.
  std::atomic<int> truncated{0};    // So many exports break off half way.
  std::atomic<int> break_lists{0};  // So many lists break off half way.
  std::atomic<int> exports{0};

  grpc::Status ListSubmaps(grpc::ServerContext*, const v1::ListSubmapsRequest*,
                           grpc::ServerWriter<v1::ListSubmapsResponse>* writer) override {
    for (uint32_t index = 0; index < 2; ++index) {
      v1::ListSubmapsResponse part;
      part.set_revision(3);
      part.add_submaps()->set_index(index);
      writer->Write(part);
      if (break_lists == 0) continue;
      --break_lists;
      return {grpc::StatusCode::UNAVAILABLE, "cable pulled"};
    }
    return grpc::Status::OK;
  }

  grpc::Status GetMapInfo(grpc::ServerContext*, const v1::GetMapInfoRequest*,
                          v1::MapInfo* info) override {
    info->set_revision(7);
    return grpc::Status::OK;
  }

  grpc::Status ExportMap(grpc::ServerContext*, const v1::ExportMapRequest*,
                         grpc::ServerWriter<v1::ExportMapResponse>* writer) override {
    ++exports;
    v1::ExportMapResponse part;
    part.set_revision(7);
    part.set_data(file.substr(0, file.size() / 2));
    if (damaged > 0) {
      --damaged;
      part.mutable_data()->at(5) ^= 1;
    } else if (truncated > 0) {
      --truncated;
      writer->Write(part);
      return {grpc::StatusCode::UNAVAILABLE, "cable pulled"};
    }
    writer->Write(part);
    part.set_data(file.substr(file.size() / 2));
    part.set_last(true);
    part.set_size(file.size());
    part.set_crc32c(io::Crc32c(file.data(), file.size()));
    writer->Write(part);
    return grpc::Status::OK;
  }
};

// Takes changes, and loses its answers to as many of them as told.
class FakeEdits final : public v1::EditService::Service {
 public:
  std::atomic<int> lose{0};
  std::atomic<int> undone{0}, removed{0}, put{0};

  grpc::Status UndoRevision(grpc::ServerContext*, const v1::UndoRevisionRequest*,
                            v1::UndoRevisionResponse*) override {
    ++undone;
    return Answer();
  }
  grpc::Status DeleteAnchor(grpc::ServerContext*, const v1::DeleteAnchorRequest*,
                            v1::DeleteAnchorResponse*) override {
    ++removed;
    return Answer();
  }
  grpc::Status PutAnchor(grpc::ServerContext*, const v1::PutAnchorRequest*,
                         v1::PutAnchorResponse*) override {
    ++put;
    return Answer();
  }

 private:
  grpc::Status Answer() {
    if (lose == 0) return grpc::Status::OK;
    --lose;
    return {grpc::StatusCode::UNAVAILABLE, "the answer was lost"};
  }
};

class FakeServer {
 public:
  // Port 0: any free one.
  explicit FakeServer(int port = 0) {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:" + std::to_string(port), grpc::InsecureServerCredentials(),
                             &port_);
    builder.RegisterService(&sessions);
    builder.RegisterService(&map);
    builder.RegisterService(&edits);
    server_ = builder.BuildAndStart();
  }
  ~FakeServer() { server_->Shutdown(std::chrono::system_clock::now()); }

  int port() const { return port_; }
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  FakeSessions sessions;
  FakeMap map;
  FakeEdits edits;

 private:
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace isthmus::client
