#include "client/readers/messages/db3/db3_reader.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <compare>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "client/readers/messages/clock_step.h"
#include "client/readers/messages/db3/bag_database.h"

namespace isthmus::readers {
namespace {

class Db3Reader : public MessageReader {
 public:
  Db3Reader(std::string path, std::map<int64_t, size_t> topic_of, int64_t last_id,
            std::unique_ptr<BagDatabase> database)
      : path_(std::move(path)),
        topic_of_(std::move(topic_of)),
        last_id_(last_id),
        database_(std::move(database)) {}

  absl::StatusOr<std::optional<Message>> Next() override;
  std::vector<std::string> Assumptions() const override {
    return step_ ? std::vector<std::string>{step_->Text()} : std::vector<std::string>();
  }

 private:
  struct Row {
    int64_t log_ns = 0, id = 0;
    size_t topic = 0;
    auto operator<=>(const Row&) const = default;
  };

  // Fills rows_ and damages_.
  void List();
  // The next row with an id above `id`, appended to rows_; false behind all.
  absl::StatusOr<bool> Step(int64_t id);
  // Finds a row behind the damaged pages after `id` by steps that double; its id, or last_id_.
  int64_t SkipDamage(int64_t id, const absl::Status& damage);
  absl::StatusOr<absl::string_view> Read(int64_t id);

  const std::string path_;
  const std::map<int64_t, size_t> topic_of_;
  const int64_t last_id_;
  const std::unique_ptr<BagDatabase> database_;
  bool listed_ = false;
  std::vector<Row> rows_;  // By their times of recording, or on either side of the step.
  std::optional<ClockStep> step_;
  size_t next_ = 0;
  std::deque<absl::Status> damages_;  // Not told yet.
  BagQuery query_;
};

absl::StatusOr<bool> Db3Reader::Step(int64_t id) {
  if (!query_.is_open()) {
    const auto number = [](std::string* out, const auto& topic) {
      absl::StrAppend(out, topic.first);
    };
    absl::StatusOr<BagQuery> query = database_->Query(
        absl::StrCat("SELECT id, topic_id, timestamp FROM messages WHERE id > ? AND topic_id IN (",
                     absl::StrJoin(topic_of_, ",", number), ") ORDER BY id"));
    if (!query.ok()) return query.status();
    query_ = *std::move(query);
    query_.Bind(id);
  }
  absl::StatusOr<bool> row = query_.Step();
  if (!row.ok() || !*row) return row;
  const auto topic = topic_of_.find(query_.Int(1));
  if (topic == topic_of_.end()) return absl::InternalError("a message of a topic not asked for");
  rows_.push_back({query_.Int(2), query_.Int(0), topic->second});
  return true;
}

int64_t Db3Reader::SkipDamage(int64_t before, const absl::Status& damage) {
  int64_t id = before;
  for (int64_t step = 1; id < last_id_; step *= 2) {
    query_ = BagQuery();
    id = step < last_id_ - before ? before + step : last_id_;
    absl::StatusOr<bool> row = Step(id);
    if (!row.ok()) continue;
    const int64_t found = *row ? rows_.back().id : last_id_ + 1;
    damages_.push_back(
        absl::DataLossError(absl::StrCat(path_, ": messages ", before + 1, " to ", found - 1,
                                         " (of all topics) cannot be read: ", damage.message())));
    return std::min(found, last_id_);
  }
  damages_.push_back(absl::DataLossError(absl::StrCat(
      path_, ": the messages behind number ", before, " cannot be read: ", damage.message())));
  return last_id_;
}

void Db3Reader::List() {
  listed_ = true;
  int64_t id = -1;  // Rows up to it are listed, or damaged.
  while (true) {
    absl::StatusOr<bool> row = Step(id);
    if (row.ok() && !*row) break;
    id = row.ok() ? rows_.back().id : SkipDamage(id, row.status());
    if (!row.ok() && id >= last_id_) break;
  }
  std::vector<LogSpan> spans;
  spans.reserve(rows_.size());
  for (const Row& one : rows_) spans.push_back({one.log_ns, one.log_ns});
  step_ = FindClockStep(spans);
  const auto set =
      rows_.begin() + static_cast<std::ptrdiff_t>(step_ && step_->was_set ? step_->at : 0);
  std::sort(rows_.begin(), set);
  std::sort(set, rows_.end());
}

absl::StatusOr<absl::string_view> Db3Reader::Read(int64_t id) {
  absl::StatusOr<BagQuery> query = database_->Query("SELECT data FROM messages WHERE id = ?");
  if (!query.ok()) return query.status();
  query_ = *std::move(query);
  query_.Bind(id);
  absl::StatusOr<bool> row = query_.Step();
  if (!row.ok()) return row.status();
  if (!*row) return absl::DataLossError("it is gone");
  return query_.Bytes(0);
}

absl::StatusOr<std::optional<Message>> Db3Reader::Next() {
  if (topic_of_.empty()) return std::nullopt;
  if (!listed_) List();
  if (!damages_.empty()) {
    const absl::Status damage = std::move(damages_.front());
    damages_.pop_front();
    return damage;
  }
  if (next_ == rows_.size()) return std::nullopt;
  const Row& row = rows_[next_++];
  absl::StatusOr<absl::string_view> bytes = Read(row.id);
  if (!bytes.ok()) {
    return absl::DataLossError(
        absl::StrCat(path_, ": message ", row.id, " cannot be read: ", bytes.status().message()));
  }
  return Message{row.topic, row.log_ns, *bytes};
}

}  // namespace

absl::StatusOr<std::unique_ptr<MessageReader>> ReadDb3(const std::string& path,
                                                       std::map<int64_t, size_t> topic_of,
                                                       int64_t last_id) {
  bool log_left_out = false;
  absl::StatusOr<std::unique_ptr<BagDatabase>> database = BagDatabase::Open(path, &log_left_out);
  if (!database.ok()) return database.status();
  return std::make_unique<Db3Reader>(path, std::move(topic_of), last_id, *std::move(database));
}

}  // namespace isthmus::readers
