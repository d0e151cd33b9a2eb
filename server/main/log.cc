#include "server/main/log.h"

#include <absl/status/statusor.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/time/time.h>
#include <fcntl.h>
#include <spdlog/formatter.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "core/io/file_io.h"
#include "core/plain_text.h"
#include "core/site_name.h"

namespace isthmus::server {
namespace {

constexpr size_t kMaxMessage = 8192;  // Longer ones are no lines for a person.

// Fields of the line that this thread is about to write; spdlog hands on the message alone.
thread_local const LogFields* current_fields = nullptr;

std::string Name(spdlog::level::level_enum level) {
  const auto name = spdlog::level::to_string_view(level);
  return std::string(name.data(), name.size());
}

std::string FormatJson(spdlog::level::level_enum level, int64_t time_ns, const std::string& message,
                       const LogFields& fields) {
  nlohmann::ordered_json line;
  line["time"] =
      absl::FormatTime("%Y-%m-%dT%H:%M:%E3SZ", absl::FromUnixNanos(time_ns), absl::UTCTimeZone());
  line["level"] = Name(level);
  line["message"] = message;
  const auto add = [&](const char* key, const std::string& value) {
    if (!value.empty()) line[key] = value;
  };
  add("site", fields.site);
  add("robot", fields.robot);
  add("session", fields.session);
  if (fields.sequence) line["sequence"] = *fields.sequence;
  add("event", fields.event);
  add("rpc", fields.rpc);
  add("code", fields.code);
  add("request_id", fields.request_id);
  add("peer", fields.peer);
  add("token", fields.token);
  return line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string FormatText(spdlog::level::level_enum level, int64_t time_ns, const std::string& message,
                       const LogFields& fields) {
  std::string line = absl::StrCat(
      absl::FormatTime("%Y-%m-%dT%H:%M:%E3S", absl::FromUnixNanos(time_ns), absl::LocalTimeZone()),
      " ", Name(level), " ");
  const bool is_named = !fields.site.empty() && fields.site != kDefaultSite;
  if (is_named) absl::StrAppend(&line, LineOf(fields.site, kMaxMessage), ": ");
  absl::StrAppend(&line, LineOf(message, kMaxMessage));
  std::vector<std::string> caller;
  const auto add = [&](const char* key, const std::string& value) {
    if (!value.empty()) caller.push_back(absl::StrCat(key, " ", LineOf(value, kMaxMessage)));
  };
  add("request", fields.request_id);
  add("peer", fields.peer);
  add("token", fields.token);
  if (!caller.empty()) absl::StrAppend(&line, " (", absl::StrJoin(caller, ", "), ")");
  return line + "\n";
}

class LineFormatter final : public spdlog::formatter {
 public:
  explicit LineFormatter(bool json) : json_(json) {}

  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    const int64_t time_ns = std::chrono::nanoseconds(message.time.time_since_epoch()).count();
    const std::string line = FormatLine(json_, message.level, time_ns,
                                        std::string(message.payload.data(), message.payload.size()),
                                        current_fields == nullptr ? LogFields() : *current_fields);
    out.append(line.data(), line.data() + line.size());
  }
  std::unique_ptr<spdlog::formatter> clone() const override {
    return std::make_unique<LineFormatter>(json_);
  }

 private:
  const bool json_;
};

class FileSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit FileSink(std::string path) : path_(std::move(path)) {}
  ~FileSink() override {
    if (file_ >= 0) ::close(file_);
  }

  absl::Status Reopen() {
    constexpr mode_t kOwnersAndGroups = 0640;
    const int file =
        ::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, kOwnersAndGroups);
    if (file < 0) return io::FileError("open", path_, errno);
    if (file_ < 0) {
      file_ = file;
      return absl::OkStatus();
    }
    // Under the number that other threads write to.
    const bool is_replaced = ::dup3(file, file_, O_CLOEXEC) >= 0;
    const int error = errno;
    ::close(file);
    return is_replaced ? absl::OkStatus() : io::FileError("reopen", path_, error);
  }

 protected:
  // A line that cannot be written is lost, as one on a stderr that is full is.
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::memory_buf_t line;
    formatter_->format(message, line);
    for (size_t written = 0; written < line.size();) {
      const ssize_t some = ::write(file_, line.data() + written, line.size() - written);
      if (some < 0 && errno == EINTR) continue;
      if (some <= 0) return;
      written += static_cast<size_t>(some);
    }
  }
  void flush_() override {}

 private:
  const std::string path_;
  int file_ = -1;  // Constant once it is open.
};

std::shared_ptr<FileSink>& TheFile() {
  static std::shared_ptr<FileSink> file;
  return file;
}

}  // namespace

LogFields FieldsOf(const Event& event, const std::string& site) {
  LogFields fields;
  fields.site = site;
  fields.robot = event.robot.value();
  fields.session = event.session.value();
  fields.event = ToString(event.kind);
  fields.request_id = event.actor.request_id;
  fields.peer = event.actor.from;
  fields.token = event.actor.who;
  return fields;
}

LogFields FieldsOf(const rpc::FailedCall& call) {
  LogFields fields;
  fields.site = call.site;
  fields.rpc = call.rpc;
  fields.code = absl::StatusCodeToString(call.status.code());
  fields.request_id = call.request_id;
  fields.peer = call.peer;
  fields.token = call.token;
  return fields;
}

absl::Status StartLogging(const LogOptions& options) {
  spdlog::sink_ptr sink = std::make_shared<spdlog::sinks::stderr_sink_mt>();
  if (!options.file.empty()) {
    auto file = std::make_shared<FileSink>(options.file);
    if (absl::Status status = file->Reopen(); !status.ok()) return status;
    TheFile() = file;
    sink = file;
  }
  auto logger = std::make_shared<spdlog::logger>("isthmus", std::move(sink));
  logger->set_formatter(std::make_unique<LineFormatter>(options.json));
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
  spdlog::set_level(spdlog::level::from_str(options.level));
  return absl::OkStatus();
}

void OnHangup() {
  constexpr char kHowToChange[] =
      "settings are read only at the start; to change them, end the server with SIGTERM and start "
      "it again";
  if (TheFile() == nullptr) return spdlog::warn("SIGHUP received and ignored: {}", kHowToChange);
  if (const absl::Status status = TheFile()->Reopen(); !status.ok()) {
    return spdlog::warn("the log continues in the old file: {}", std::string(status.message()));
  }
  spdlog::info("SIGHUP received: the log continues in this file; {}", kHowToChange);
}

void Log(spdlog::level::level_enum level, const std::string& message, const LogFields& fields) {
  current_fields = &fields;
  spdlog::log(level, "{}", message);
  current_fields = nullptr;
}

std::string FormatLine(bool json, spdlog::level::level_enum level, int64_t time_ns,
                       const std::string& message, const LogFields& fields) {
  return json ? FormatJson(level, time_ns, message, fields)
              : FormatText(level, time_ns, message, fields);
}

}  // namespace isthmus::server
