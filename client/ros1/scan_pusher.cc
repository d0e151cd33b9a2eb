#include "client/ros1/scan_pusher.h"

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <ros/console.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "client/ros1/limits.h"

namespace isthmus::ros1 {

ScanPusher::ScanPusher(const Parameters& parameters, ScanQueue& queue, OnAck on_ack)
    : parameters_(parameters),
      on_ack_([this, on_ack = std::move(on_ack)](const ScanAck& ack) {
        on_ack(ack);
        acked_.SignalAll();
      }),
      reader_(ReadQueue(queue, parameters.points, parameters.read)) {}

client::ScanStreamOptions ScanPusher::StreamOptions() const {
  client::ScanStreamOptions options;
  options.resolution_m = parameters_.resolution_m;
  options.spool_dir = parameters_.spool;
  options.spool.max_bytes = static_cast<uint64_t>(parameters_.spool_gb * 1e9);
  options.spool.when_full = client::WhenFull::kDropOldest;
  options.spool.if_session_is_gone = client::IfSessionIsGone::kNewSession;
  options.spool.prefer_live_after_s = parameters_.prefer_live_after_s;
  options.on_ack = on_ack_;
  options.on_event = [](const std::string& event) { ROS_INFO("%s", event.c_str()); };
  return options;
}

absl::Status ScanPusher::Resume() {
  auto stream = client_->ResumeScanStream(StreamOptions());
  if (absl::IsNotFound(stream.status()) || absl::IsAlreadyExists(stream.status())) {
    return absl::OkStatus();
  }
  if (!stream.ok()) return stream.status();
  const client::SpoolState state = (*stream)->resumed();
  if (state.robot != parameters_.robot) {
    return absl::FailedPreconditionError(absl::StrCat("the spool ", parameters_.spool,
                                                      " holds scans of robot ", state.robot,
                                                      ": name another folder with ~spool"));
  }
  ROS_INFO("going on after scan %lu of %s", state.last_sequence,
           state.session.empty() ? "a session that the server does not know yet"
                                 : state.session.value().c_str());
  stream_ = *std::move(stream);
  return absl::OkStatus();
}

absl::Status ScanPusher::Open() {
  std::string sensor = reader_->sensor();
  if (sensor.empty()) {
    sensor = "spinning";
    ROS_WARN("nothing tells the sensor: taken for one that spins; say which with ~sensor");
  }
  auto stream =
      client_->OpenSpool({RobotId(parameters_.robot), sensor, std::nullopt}, StreamOptions());
  if (!stream.ok()) return stream.status();
  ROS_INFO("a new session of %s, sensor %s, spool %s", parameters_.robot.c_str(), sensor.c_str(),
           parameters_.spool.c_str());
  stream_ = *std::move(stream);
  return absl::OkStatus();
}

absl::Status ScanPusher::Push(readers::RecordedScan scan) {
  if (stream_ == nullptr) {
    if (absl::Status status = Open(); !status.ok()) return status;
  }
  absl::Status status = stream_->Push(scan.end_stamp_ns, std::move(scan.payload));
  // Errors that the disk or the scan is to blame for may be gone with the next scan.
  if (absl::IsInvalidArgument(status) || absl::IsResourceExhausted(status) ||
      absl::IsUnavailable(status)) {
    ROS_ERROR_THROTTLE(kComplaintPeriodS, "%s is lost: %s", scan.name.c_str(),
                       std::string(status.message()).c_str());
    return absl::OkStatus();
  }
  return status;
}

void ScanPusher::NoteAssumptions() {
  const std::vector<std::string> assumptions = reader_->Assumptions();
  for (; assumptions_noted_ < assumptions.size(); ++assumptions_noted_) {
    ROS_INFO("%s", assumptions[assumptions_noted_].c_str());
  }
}

void ScanPusher::FinishSession() {
  const absl::Time deadline = absl::Now() + absl::Seconds(kFinishS);
  {
    MutexLock lock(&mutex_);
    while (stream_->stats().backlog > 0 && absl::Now() < deadline) {
      // Acknowledgements are signalled without the mutex, so one may be missed.
      acked_.WaitFor(&mutex_, std::chrono::milliseconds(100));
    }
  }
  // It would wait for the server as long as it takes.
  if (stream_->stats().backlog > 0) {
    ROS_WARN("%lu scans wait in %s: the next run sends them, in the same session",
             stream_->stats().backlog, parameters_.spool.c_str());
    return;
  }
  const auto session = stream_->FinishSession();
  if (!session.ok()) {
    ROS_ERROR("the session was not finished: %s", std::string(session.status().message()).c_str());
  }
}

absl::Status ScanPusher::Run() {
  std::error_code error;  // The spool reports a bad folder better.
  std::filesystem::create_directories(parameters_.spool, error);
  client::ClientOptions options;
  options.address = parameters_.server;
  options.require_server = false;  // A robot may start out of reach.
  auto client = client::Client::Connect(options);
  if (!client.ok()) return client.status();
  client_ = *std::move(client);
  if (absl::Status status = Resume(); !status.ok()) return status;
  while (true) {
    absl::StatusOr<std::optional<readers::RecordedScan>> scan = reader_->Next();
    NoteAssumptions();
    if (!scan.ok()) {
      ROS_WARN_THROTTLE(kComplaintPeriodS, "left out %s",
                        std::string(scan.status().message()).c_str());
      continue;
    }
    if (!scan->has_value()) break;
    if (absl::Status status = Push(**std::move(scan)); !status.ok()) return status;
  }
  if (parameters_.finish && stream_ != nullptr) FinishSession();
  return absl::OkStatus();
}

}  // namespace isthmus::ros1
