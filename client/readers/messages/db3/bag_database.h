// Read-only access to a database that belongs to somebody else.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <memory>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace isthmus::readers {

// A query at work. Not thread safe; must not outlive its database.
class BagQuery {
 public:
  BagQuery() = default;
  explicit BagQuery(sqlite3_stmt* statement) : statement_(statement) {}
  BagQuery(BagQuery&& other) noexcept;
  BagQuery& operator=(BagQuery&& other) noexcept;
  ~BagQuery();

  bool is_open() const { return statement_ != nullptr; }
  void Bind(int64_t value);  // The first parameter, before the first step.
  // True when there is a row. DataLoss for damaged pages, Unavailable for other errors.
  absl::StatusOr<bool> Step();
  // Columns of the row, from 0.
  int64_t Int(int column) const;
  absl::string_view Bytes(int column) const;  // Valid until the next step.

 private:
  sqlite3_stmt* statement_ = nullptr;
};

// One connection. Not thread safe.
class BagDatabase {
 public:
  // Neither the file nor its folder is written to, nor are locks taken: of a database that is
  // being written to what is read may be damaged. With a write-ahead log beside it that is read
  // too, from memory; `log_left_out` says where it could not be. DataLoss where it cannot be read.
  static absl::StatusOr<std::unique_ptr<BagDatabase>> Open(const std::string& path,
                                                           bool* log_left_out);
  ~BagDatabase();
  BagDatabase(const BagDatabase&) = delete;
  BagDatabase& operator=(const BagDatabase&) = delete;

  absl::StatusOr<BagQuery> Query(const std::string& sql);

 private:
  explicit BagDatabase(sqlite3* database) : database_(database) {}
  static absl::StatusOr<std::unique_ptr<BagDatabase>> OpenAs(const std::string& uri, bool with_log);

  sqlite3* const database_;
};

}  // namespace isthmus::readers
