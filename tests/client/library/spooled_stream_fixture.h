// A robot with a spool, and a server that comes and goes: over a real socket, or without a network.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "client/library/stream/scan_stream.h"
#include "core/codec/payload_builder.h"
#include "core/concurrency/mutex.h"
#include "tests/client/library/manual_wait_clock.h"
#include "tests/client/library/spool_files.h"

#ifdef ISTHMUS_TEST_WITHOUT_NETWORK
#include "tests/client/library/durable_link.h"
#else
#include "tests/client/library/durable_server.h"
#endif

namespace isthmus::client {

class SpooledStreamTest : public testing::Test {
 protected:
  SpooledStreamTest() { options_.spool_dir = files_.path() + "/robot"; }

  void SetUp() override {
    ClientOptions options;
    options.require_server = false;
    options.clock = &clock_;
    options.sleep = [this](double seconds) {
      MutexLock lock(&mutex_);
      waits_.push_back(seconds);
      if (on_wait_) on_wait_();
    };
    client_ = server_.Connect(options);
    ASSERT_NE(client_, nullptr);
    options_.on_ack = [this](const ScanAck& ack) {
      MutexLock lock(&mutex_);
      acks_.push_back(ack);
    };
    options_.on_event = [this](const std::string& event) {
      MutexLock lock(&mutex_);
      events_.push_back(event);
    };
  }

  std::unique_ptr<ScanStream> Open() {
    auto stream = client_->OpenSpool({RobotId("alice"), "vlp16"}, options_);
    EXPECT_TRUE(stream.ok()) << stream.status();
    return *std::move(stream);
  }

  static constexpr int64_t kPeriodNs = 100'000'000;
  // The scan that was pushed as the k-th, from 1; its stamp tells which.
  static PointPayload PayloadOf(uint64_t k) {
    return codec::MakePayload(Cloud{{static_cast<float>(k), 2, 3, 4}});
  }
  absl::Status PushOne(ScanStream& stream) {
    const uint64_t k = pushed_ + 1;
    const absl::Status status = stream.Push(static_cast<int64_t>(k) * kPeriodNs, PayloadOf(k));
    if (status.ok()) pushed_ = k;
    return status;
  }
  void Push(ScanStream& stream, int scans) {
    for (int i = 0; i < scans; ++i) {
      const absl::Status status = PushOne(stream);
      ASSERT_TRUE(status.ok()) << status;
    }
  }

  // The session holds the scans that were pushed as the from-th to the to-th, each once and in
  // order, bit for bit.
  void ExpectScans(const std::string& session, uint64_t from, uint64_t to) {
    const std::vector<v1::ScanMessage> scans = server_.sessions()[session].scans;
    ASSERT_EQ(scans.size(), to + 1 - from) << session;
    for (uint64_t k = from; k <= to; ++k) {
      const v1::ScanMessage& scan = scans[k - from];
      EXPECT_EQ(scan.sequence(), k + 1 - from);
      EXPECT_EQ(scan.end_stamp_ns(), static_cast<int64_t>(k) * kPeriodNs);
      EXPECT_EQ(scan.cloud().data(), PayloadOf(k).data);
    }
  }

  std::vector<ScanAck> acks() {
    MutexLock lock(&mutex_);
    return acks_;
  }
  std::string events() {
    MutexLock lock(&mutex_);
    std::string all;
    for (const std::string& event : events_) all += event + "\n";
    return all;
  }

  SpoolFiles files_;
  ManualWaitClock clock_;
  ScanStreamOptions options_;
  TestServer server_;
  Mutex mutex_;
  std::vector<double> waits_ ABSL_GUARDED_BY(mutex_);
  std::function<void()> on_wait_ ABSL_GUARDED_BY(mutex_);
  std::vector<ScanAck> acks_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::string> events_ ABSL_GUARDED_BY(mutex_);
  uint64_t pushed_ = 0;
  decltype(server_.Connect({})) client_;
};

}  // namespace isthmus::client
