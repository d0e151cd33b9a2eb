#include "client/readers/messages/db3/db3_file.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "client/readers/messages/db3/bag_database.h"
#include "client/readers/messages/db3/db3_reader.h"
#include "client/readers/messages/limits.h"

namespace isthmus::readers {
namespace {

class Db3File : public MessageFile {
 public:
  explicit Db3File(std::string path) : path_(std::move(path)) {}

  absl::Status Open();
  std::string kind() const override { return "ROS 2 bag (db3)"; }
  const std::vector<MessageTopic>& topics() const override { return topics_; }
  std::vector<std::string> notes() const override { return notes_; }
  absl::StatusOr<std::unique_ptr<MessageReader>> OpenPacked(
      std::vector<size_t> topics) const override;

 private:
  absl::Status ReadTopics(BagDatabase& database);
  void Count(BagDatabase& database);

  const std::string path_;
  std::vector<MessageTopic> topics_;
  std::map<int64_t, size_t> topic_of_;  // By the id in the database.
  int64_t last_id_ = 0;                 // The highest of messages; 0 if it cannot be told.
  std::vector<std::string> notes_;
};

absl::Status Db3File::Open() {
  bool log_left_out = false;
  absl::StatusOr<std::unique_ptr<BagDatabase>> database = BagDatabase::Open(path_, &log_left_out);
  if (!database.ok()) {
    return absl::Status(database.status().code(),
                        absl::StrCat(path_, ": ", database.status().message()));
  }
  if (log_left_out) {
    notes_.push_back(absl::StrCat("what a recorder left in ", path_, "-wal cannot be read"));
  }
  if (absl::Status status = ReadTopics(**database); !status.ok()) return status;
  Count(**database);
  return absl::OkStatus();
}

absl::Status Db3File::ReadTopics(BagDatabase& database) {
  absl::StatusOr<BagQuery> query =
      database.Query("SELECT id, name, type, serialization_format FROM topics");
  const absl::StatusOr<BagQuery> messages =
      database.Query("SELECT id, topic_id, timestamp, data FROM messages");
  if (!query.ok() || !messages.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(
        path_, " is a database, but no ROS 2 bag with its tables `topics` and `messages`: ",
        query.ok() ? messages.status().message() : query.status().message()));
  }
  std::map<std::tuple<std::string, std::string, std::string>, std::vector<int64_t>> sorted;
  while (true) {
    absl::StatusOr<bool> row = query->Step();
    if (!row.ok()) notes_.push_back(absl::StrCat("topics are lost: ", row.status().message()));
    if (!row.ok() || !*row) break;
    // Old recorders leave the format empty: there was one.
    const absl::string_view format = query->Bytes(3);
    sorted[{std::string(query->Bytes(1)), ShortType(query->Bytes(2)),
            std::string(format.empty() ? "cdr" : format)}]
        .push_back(query->Int(0));
  }
  for (const auto& [names, ids] : sorted) {
    for (const int64_t id : ids) topic_of_.emplace(id, topics_.size());
    topics_.push_back({std::get<0>(names), std::get<1>(names), std::get<2>(names)});
  }
  return absl::OkStatus();
}

// Stops at damage: it shows again when the messages are read.
void Db3File::Count(BagDatabase& database) {
  absl::StatusOr<BagQuery> last = database.Query("SELECT max(id) FROM messages");
  if (!last.ok()) return;
  if (absl::StatusOr<bool> row = last->Step(); !row.ok() || !*row) return;
  last_id_ = last->Int(0);
  if (last_id_ > kMaxCountedMessages) return;
  absl::StatusOr<BagQuery> counts =
      database.Query("SELECT topic_id, count(*) FROM messages GROUP BY topic_id");
  if (!counts.ok()) return;
  std::vector<uint64_t> totals(topics_.size());
  while (true) {
    absl::StatusOr<bool> row = counts->Step();
    if (!row.ok()) return;
    if (!*row) break;
    const auto topic = topic_of_.find(counts->Int(0));
    if (topic != topic_of_.end()) totals[topic->second] += static_cast<uint64_t>(counts->Int(1));
  }
  for (size_t i = 0; i < topics_.size(); ++i) topics_[i].messages = totals[i];
}

absl::StatusOr<std::unique_ptr<MessageReader>> Db3File::OpenPacked(
    std::vector<size_t> topics) const {
  std::map<int64_t, size_t> wanted;
  for (const auto& [id, topic] : topic_of_) {
    if (std::find(topics.begin(), topics.end(), topic) != topics.end()) wanted.emplace(id, topic);
  }
  return ReadDb3(path_, std::move(wanted), last_id_);
}

}  // namespace

absl::StatusOr<std::shared_ptr<const MessageFile>> OpenDb3(const std::string& path) {
  auto file = std::make_shared<Db3File>(path);
  if (absl::Status status = file->Open(); !status.ok()) return status;
  return file;
}

}  // namespace isthmus::readers
