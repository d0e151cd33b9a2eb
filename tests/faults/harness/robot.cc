#include "tests/faults/harness/robot.h"

#include <chrono>
#include <stdexcept>

#include "tests/faults/harness/room_robot.h"

namespace isthmus::faults {

void AckCounter::Add() {
  MutexLock lock(&mutex_);
  ++count_;
  changed_.SignalAll();
}

uint64_t AckCounter::count() const {
  MutexLock lock(&mutex_);
  return count_;
}

bool AckCounter::WaitFor(uint64_t count, double timeout_s) const {
  MutexLock lock(&mutex_);
  const double until = NowS() + timeout_s;
  while (count_ < count && NowS() < until) {
    changed_.WaitFor(&mutex_, std::chrono::duration<double>(until - NowS()));
  }
  return count_ >= count;
}

double NowS() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

client::ClientOptions PatientClient(const std::string& address) {
  client::ClientOptions options;
  options.address = address;
  options.backoff = {
      .first_delay_s = 0.02, .factor = 1.5, .max_delay_s = 0.2, .max_attempts = 1'000'000};
  return options;
}

Robot::Robot(const RobotOptions& options, AckCounter* acks) : options_(options), counter_(acks) {
  auto client = client::Client::Connect(PatientClient(options.address));
  if (!client.ok()) throw std::runtime_error(std::string(client.status().message()));
  client_ = *std::move(client);
  const auto session = client_->CreateSession(RobotName(options.robot), "vlp16");
  if (!session.ok()) throw std::runtime_error(std::string(session.status().message()));
  session_ = session->record.id;
  client::ScanStreamOptions stream = options.stream;
  stream.on_ack = [this](const ScanAck& ack) {
    {
      MutexLock lock(&mutex_);
      acks_.push_back(ack);
      acked_s_.push_back(NowS());
    }
    if (counter_ != nullptr) counter_->Add();
  };
  auto opened = client_->OpenScanStream(session_, stream);
  if (!opened.ok()) throw std::runtime_error(std::string(opened.status().message()));
  stream_ = *std::move(opened);
}

Robot::~Robot() {
  stopping_ = true;
  stream_.reset();
  if (thread_.joinable()) thread_.join();
}

void Robot::Drive() {
  thread_ = std::thread([this] { Push(); });
}

void Robot::Push() {
  auto due = std::chrono::steady_clock::now();
  for (uint64_t scan = 1; !stopping_ && (options_.scans == 0 || scan <= options_.scans); ++scan) {
    const absl::Status status = stream_->Push(RobotStamp(scan), RobotScan(options_.robot, scan));
    {
      MutexLock lock(&mutex_);
      result_ = status;
      if (!status.ok()) return;
      pushed_ = scan;
      pushed_s_.push_back(NowS());
    }
    due += std::chrono::microseconds(static_cast<int64_t>(1e6 * options_.period_s));
    if (options_.period_s > 0) std::this_thread::sleep_until(due);
  }
}

void Robot::Stop() { stopping_ = true; }

absl::Status Robot::Finish() {
  if (thread_.joinable()) thread_.join();
  {
    MutexLock lock(&mutex_);
    if (!result_.ok()) return result_;
  }
  if (absl::Status status = stream_->Finish(); !status.ok()) return status;
  return client_->FinishSession(session_).status();
}

uint64_t Robot::pushed() const {
  MutexLock lock(&mutex_);
  return pushed_;
}

uint64_t Robot::durable() const { return stream_->stats().durable_sequence; }

std::vector<ScanAck> Robot::acks() const {
  MutexLock lock(&mutex_);
  return acks_;
}

std::vector<double> Robot::pushed_s() const {
  MutexLock lock(&mutex_);
  return pushed_s_;
}

std::vector<double> Robot::acked_s() const {
  MutexLock lock(&mutex_);
  return acked_s_;
}

}  // namespace isthmus::faults
