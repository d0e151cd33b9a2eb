#include "storage/sql/connection.h"

#include <absl/strings/str_cat.h>

#include <cmath>
#include <limits>

namespace isthmus::storage {

Statement::Statement(Statement&& other) noexcept
    : compiled_(std::exchange(other.compiled_, nullptr)),
      bound_(other.bound_),
      status_(std::move(other.status_)) {}

Statement::~Statement() {
  if (compiled_ != nullptr) compiled_->Reset();
}

Statement& Statement::Note(absl::Status status) {
  if (status_.ok()) status_ = std::move(status);
  return *this;
}

Statement& Statement::Bind(int64_t value) {
  if (!status_.ok()) return *this;
  return Note(compiled_->BindNumber(++bound_, value));
}

Statement& Statement::Bind(double value) {
  if (!status_.ok()) return *this;
  if (std::isnan(value)) return BindNull();
  return Note(compiled_->BindReal(++bound_, value));
}

Statement& Statement::Bind(const std::string& text) {
  if (!status_.ok()) return *this;
  return Note(compiled_->BindText(++bound_, text));
}

Statement& Statement::BindBlob(const std::string& bytes) {
  if (!status_.ok()) return *this;
  return Note(compiled_->BindBlob(++bound_, bytes));
}

Statement& Statement::BindNull() {
  if (!status_.ok()) return *this;
  return Note(compiled_->BindNull(++bound_));
}

absl::StatusOr<bool> Statement::Step() {
  if (!status_.ok()) return status_;
  absl::StatusOr<bool> has_row = compiled_->Step();
  if (!has_row.ok()) status_ = has_row.status();
  return has_row;
}

absl::Status Statement::Run() {
  if (status_.ok()) status_ = compiled_->Run();
  bound_ = 0;
  return status_;
}

absl::StatusOr<int64_t> Statement::Change() {
  if (!status_.ok()) return status_;
  absl::StatusOr<int64_t> changed = compiled_->Change();
  if (!changed.ok()) status_ = changed.status();
  bound_ = 0;
  return changed;
}

uint32_t Statement::Uint32(int column) const {
  const int64_t number = Int(column);
  if (number >= 0 && number <= std::numeric_limits<uint32_t>::max()) {
    return static_cast<uint32_t>(number);
  }
  if (status_.ok()) {
    status_ = absl::DataLossError(absl::StrCat(
        "a record of the map has the number ", number, " where 32 bits are to hold it: it is ",
        "damaged. `isthmus-server --check` says which; restore a backup"));
  }
  return 0;
}

double Statement::Real(int column) const {
  return IsNull(column) ? std::numeric_limits<double>::quiet_NaN() : compiled_->Real(column);
}

Statement Connection::Prepare(const std::string& sql) {
  if (const auto found = cache_.find(sql); found != cache_.end()) {
    return Statement(found->second.get(), absl::OkStatus());
  }
  absl::StatusOr<std::unique_ptr<CompiledStatement>> compiled = Compile(sql);
  if (!compiled.ok()) return Statement(nullptr, compiled.status());
  return Statement((cache_[sql] = *std::move(compiled)).get(), absl::OkStatus());
}

absl::StatusOr<int64_t> Connection::ReadNumber(const std::string& sql) {
  Statement statement = Prepare(sql);
  const absl::StatusOr<bool> has_row = statement.Step();
  if (!has_row.ok()) return has_row.status();
  return *has_row ? statement.Int(0) : 0;
}

Transaction::Transaction(Connection& database, Kind kind) : database_(database) {
  status_ = kind == Kind::kWrite ? database_.BeginWrite() : database_.BeginRead();
  open_ = status_.ok();
}

Transaction::~Transaction() {
  if (open_) database_.Rollback();
}

absl::Status Transaction::Commit() {
  absl::Status status = database_.Commit();
  if (status.ok()) open_ = false;
  return status;
}

Savepoint::Savepoint(Connection& database) : database_(database) {
  status_ = database_.Prepare("SAVEPOINT part").Run();
  open_ = status_.ok();
}

Savepoint::~Savepoint() {
  // Takes back the changes since, and forgets the savepoint itself.
  if (open_) database_.Execute("ROLLBACK TO part; RELEASE part").IgnoreError();
}

absl::Status Savepoint::Release() {
  absl::Status status = database_.Prepare("RELEASE part").Change().status();
  if (status.ok()) open_ = false;
  return status;
}

}  // namespace isthmus::storage
