#include "client/console/pushed_recording.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <vector>

#include "client/library/spool/spool_options.h"
#include "core/io/crc32c.h"
#include "core/io/file_io.h"
#include "core/io/of_file.h"
#include "core/io/part_file.h"

namespace isthmus::cli {
namespace {

std::string PathIn(const std::string& spool) { return spool + "/pushed"; }

// Another database may have a session of the same name.
std::string NoteOf(const RecordingSum& recording, const SessionStatus& session) {
  return absl::StrCat(session.record.robot.value(), "\n", session.record.id.value(), "\ncreated ",
                      session.record.created_ns, ", ", session.last_sequence, " scans of ",
                      recording.text(), "\n");
}

// Nothing where it cannot be read, or the push was stopped.
std::optional<RecordingSum> SumOf(const RobotScans& robot, const PushControl& control) {
  const auto reader = robot.read_again();
  if (!reader.ok()) return std::nullopt;
  RecordingSum sum;
  while (!control.stopped()) {
    const auto scan = (*reader)->Next();
    if (!scan.ok()) continue;
    if (!scan->has_value()) return sum;
    sum.Add(**scan);
  }
  return std::nullopt;
}

}  // namespace

void RecordingSum::Add(const readers::RecordedScan& scan) {
  ++scans_;
  sum_ = io::Crc32c(&scan.end_stamp_ns, sizeof(scan.end_stamp_ns), sum_);
  sum_ = io::Crc32c(scan.payload.data.data(), scan.payload.data.size(), sum_);
}

std::string RecordingSum::text() const { return absl::StrCat(scans_, " with checksum ", sum_); }

absl::Status NotePushed(const std::string& spool, const RecordingSum& recording,
                        const SessionStatus& session) {
  return io::OfFile(io::ReplaceFile(PathIn(spool), NoteOf(recording, session)));
}

absl::StatusOr<std::optional<SessionStatus>> FindPushed(client::Client& client,
                                                        const RobotScans& robot,
                                                        const std::string& spool,
                                                        const PushControl& control) {
  if (robot.read_again == nullptr) return std::nullopt;
  const absl::StatusOr<std::string> note = io::ReadFile(PathIn(spool));
  if (absl::IsNotFound(note.status())) return std::nullopt;
  if (!note.ok()) return io::OfFile(note.status());
  const std::vector<std::string> lines = absl::StrSplit(*note, '\n');
  if (lines.size() < 2 || lines[0] != robot.robot) return std::nullopt;
  const auto session = AwaitSession(client, SessionId(lines[1]), control);
  if (absl::IsNotFound(session.status())) return std::nullopt;
  if (!session.ok()) return session.status();
  if (session->record.state != SessionState::kFinished) return std::nullopt;
  const std::optional<RecordingSum> recording = SumOf(robot, control);
  if (control.stopped()) return absl::CancelledError("the push was stopped");
  if (!recording || NoteOf(*recording, *session) != *note) return std::nullopt;
  return *session;
}

bool IsAway(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status);
}

absl::StatusOr<SessionStatus> AwaitSession(client::Client& client, const SessionId& id,
                                           const PushControl& control) {
  const client::SpoolOptions patience;
  const std::chrono::duration<double> pause(patience.retry_max_s);
  for (double timeout_s = patience.attempt_timeout_s;; std::this_thread::sleep_for(pause)) {
    auto session = client.GetSessionOnce(id, timeout_s);
    if (!IsAway(session.status())) return session;
    if (control.stopped()) return absl::CancelledError("the push was stopped");
    timeout_s = std::min(2 * timeout_s, patience.stall_timeout_s);  // A slow link's.
  }
}

}  // namespace isthmus::cli
