#include "client/readers/messages/db3/db3_reader.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <utility>
#include <vector>

#include "client/readers/messages/db3/bag_database.h"
#include "client/readers/messages/unpack.h"

namespace isthmus::readers {
namespace {

class Db3Reader : public MessageReader {
 public:
  Db3Reader(std::string path, std::map<int64_t, size_t> topic_of, int64_t last_id, bool packed,
            std::unique_ptr<BagDatabase> database)
      : path_(std::move(path)),
        topic_of_(std::move(topic_of)),
        last_id_(last_id),
        packed_(packed),
        database_(std::move(database)) {
    std::vector<int64_t> ids;
    for (const auto& [id, topic] : topic_of_) ids.push_back(id);
    sql_ = absl::StrCat("SELECT id, topic_id, timestamp, data FROM messages WHERE id > ? AND ",
                        "topic_id IN (", absl::StrJoin(ids, ","), ") ORDER BY id");
  }

  absl::StatusOr<std::optional<Message>> Next() override;

 private:
  // The row behind the last one that was read; false behind all.
  absl::StatusOr<bool> Step();
  // Finds a message behind the damaged pages by steps that double.
  absl::Status SkipDamage(const absl::Status& damage);

  const std::string path_;
  const std::map<int64_t, size_t> topic_of_;
  const int64_t last_id_;
  const bool packed_;
  const std::unique_ptr<BagDatabase> database_;
  std::string sql_;
  BagQuery query_;
  int64_t id_ = -1;          // That all read ones are not above.
  bool row_is_new_ = false;  // SkipDamage has stepped onto it.
  bool ended_ = false;
  std::string content_;
};

absl::StatusOr<bool> Db3Reader::Step() {
  if (std::exchange(row_is_new_, false)) return true;
  if (!query_.is_open()) {
    absl::StatusOr<BagQuery> query = database_->Query(sql_);
    if (!query.ok()) return query.status();
    query_ = *std::move(query);
    query_.Bind(id_);
  }
  return query_.Step();
}

absl::Status Db3Reader::SkipDamage(const absl::Status& damage) {
  const int64_t before = id_;
  for (int64_t step = 1; id_ < last_id_; step *= 2) {
    query_ = BagQuery();
    id_ = step < last_id_ - before ? before + step : last_id_;
    absl::StatusOr<bool> row = Step();
    if (!row.ok()) continue;
    row_is_new_ = *row;
    ended_ = !*row;
    return absl::DataLossError(absl::StrCat(path_, ": messages ", before + 1, " to ",
                                            row_is_new_ ? query_.Int(0) - 1 : last_id_,
                                            " (of all topics) cannot be read: ", damage.message()));
  }
  ended_ = true;
  return absl::DataLossError(absl::StrCat(path_, ": the messages behind number ", before,
                                          " cannot be read: ", damage.message()));
}

absl::StatusOr<std::optional<Message>> Db3Reader::Next() {
  if (ended_ || topic_of_.empty()) return std::nullopt;
  absl::StatusOr<bool> row = Step();
  if (!row.ok()) return SkipDamage(row.status());
  if (!*row) {
    ended_ = true;
    return std::nullopt;
  }
  id_ = query_.Int(0);
  const auto topic = topic_of_.find(query_.Int(1));
  if (topic == topic_of_.end()) return absl::InternalError("a message of a topic not asked for");
  Message message{topic->second, query_.Int(2), query_.Bytes(3)};
  if (packed_) {
    absl::Status status = UnpackZstdMessage(message.bytes, &content_);
    if (!status.ok()) {
      return absl::DataLossError(
          absl::StrCat(path_, ": message ", id_, " cannot be read: ", status.message()));
    }
    message.bytes = content_;
  }
  return message;
}

}  // namespace

absl::StatusOr<std::unique_ptr<MessageReader>> ReadDb3(const std::string& path,
                                                       std::map<int64_t, size_t> topic_of,
                                                       int64_t last_id, bool packed) {
  bool log_left_out = false;
  absl::StatusOr<std::unique_ptr<BagDatabase>> database = BagDatabase::Open(path, &log_left_out);
  if (!database.ok()) return database.status();
  return std::make_unique<Db3Reader>(path, std::move(topic_of), last_id, packed,
                                     *std::move(database));
}

}  // namespace isthmus::readers
