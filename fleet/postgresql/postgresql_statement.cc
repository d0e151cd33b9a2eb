#include "fleet/postgresql/postgresql_statement.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>

#include <bit>
#include <string_view>

namespace isthmus::storage {
namespace {

// Types of the catalogue pg_type; they never change.
constexpr Oid kBool = 16;      // Format
constexpr Oid kBytes = 17;     // Format
constexpr Oid kInt64 = 20;     // Format
constexpr Oid kInt32 = 23;     // Format
constexpr Oid kText = 25;      // Format
constexpr Oid kName = 19;      // Format
constexpr Oid kFloat64 = 701;  // Format

std::string BigEndian(uint64_t value) {
  std::string bytes(sizeof(value), '\0');
  for (size_t i = 0; i < sizeof(value); ++i) {
    bytes[i] = static_cast<char>(value >> (8 * (sizeof(value) - 1 - i)));
  }
  return bytes;
}

uint64_t FromBigEndian(const char* bytes, int size) {
  uint64_t value = 0;
  for (int i = 0; i < size; ++i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

// `?` outside of quotes becomes $1, $2 and so on.
std::string WithNumberedParameters(const std::string& sql) {
  std::string numbered;
  bool is_quoted = false;
  int count = 0;
  for (const char c : sql) {
    is_quoted = is_quoted != (c == '\'');
    if (c == '?' && !is_quoted) {
      absl::StrAppend(&numbered, "$", ++count);
    } else {
      numbered += c;
    }
  }
  return numbered;
}

}  // namespace

// https://www.postgresql.org/docs/15/errcodes-appendix.html
absl::Status StatusOf(const PGresult* result) {
  switch (PQresultStatus(result)) {
    case PGRES_COMMAND_OK:
    case PGRES_TUPLES_OK:
    case PGRES_EMPTY_QUERY:
    case PGRES_PIPELINE_SYNC:
      return absl::OkStatus();
    default:
      break;
  }
  const char* field = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  const std::string_view code = field == nullptr ? "" : field;
  const char* text = PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY);
  const std::string message =
      absl::StrCat("PostgreSQL: ", text == nullptr ? PQresultErrorMessage(result) : text,
                   code.empty() ? "" : absl::StrCat(" (", std::string(code), ")"));
  const std::string_view family = code.substr(0, 2);
  if (code == "53100") {
    return absl::ResourceExhaustedError(absl::StrCat(message, "; free some space on its disk"));
  }
  if (code == "53200" || code == "53400") return absl::ResourceExhaustedError(message);
  if (code == "40001" || code == "40P01") return absl::AbortedError(message);
  if (family == "XX" && code != "XX000") return absl::DataLossError(message);
  if (family == "22" || family == "54") return absl::InvalidArgumentError(message);
  if (code == "25006" || code == "42501" || family == "28" || family == "3D") {
    return absl::FailedPreconditionError(message);
  }
  if (code.empty() || family == "08" || family == "53" || family == "55" || family == "57" ||
      family == "58") {
    return absl::UnavailableError(message);
  }
  return absl::InternalError(message);
}

PostgresStatement::PostgresStatement(PostgresConnection& connection, const std::string& sql)
    : connection_(connection), sql_(WithNumberedParameters(sql)) {}

absl::Status PostgresStatement::Bind(int parameter, Oid type, std::string bytes) {
  const auto count = static_cast<size_t>(parameter);
  if (parameters_.size() < count) parameters_.resize(count);
  parameters_[count - 1] = {type, std::move(bytes)};
  return absl::OkStatus();
}

absl::Status PostgresStatement::BindNumber(int parameter, int64_t value) {
  return Bind(parameter, kInt64, BigEndian(static_cast<uint64_t>(value)));
}

absl::Status PostgresStatement::BindReal(int parameter, double value) {
  return Bind(parameter, kFloat64, BigEndian(std::bit_cast<uint64_t>(value)));
}

absl::Status PostgresStatement::BindText(int parameter, const std::string& text) {
  if (text.find('\0') != std::string::npos) {
    return absl::InvalidArgumentError("a text with a zero byte, which PostgreSQL cannot keep");
  }
  return Bind(parameter, kText, text);
}

absl::Status PostgresStatement::BindBlob(int parameter, const std::string& bytes) {
  return Bind(parameter, kBytes, bytes);
}

absl::Status PostgresStatement::BindNull(int parameter) { return Bind(parameter, 0, ""); }

bool PostgresStatement::SendPreparation(PGconn* connection, const std::string& name) {
  name_ = name;
  std::vector<Oid> types;
  for (const Parameter& parameter : parameters_) types.push_back(parameter.type);
  return PQsendPrepare(connection, name_.c_str(), sql_.c_str(), static_cast<int>(types.size()),
                       types.data()) == 1;
}

bool PostgresStatement::SendExecution(PGconn* connection) const {
  std::vector<const char*> values;
  std::vector<int> sizes;
  for (const Parameter& parameter : parameters_) {
    values.push_back(parameter.type == 0 ? nullptr : parameter.bytes.data());
    sizes.push_back(static_cast<int>(parameter.bytes.size()));
  }
  const std::vector<int> binary(values.size(), 1);
  return PQsendQueryPrepared(connection, name_.c_str(), static_cast<int>(values.size()),
                             values.data(), sizes.data(), binary.data(), 1) == 1;
}

absl::Status PostgresStatement::Take(Result answer) {
  for (int column = 0; column < PQnfields(answer.get()); ++column) {
    switch (PQftype(answer.get(), column)) {
      case kBool:
      case kBytes:
      case kInt64:
      case kInt32:
      case kText:
      case kName:
      case kFloat64:
        continue;
      default:
        return absl::InternalError(
            absl::StrCat("column ", column, " of \"", sql_, "\" has a type that is not read here"));
    }
  }
  answer_ = std::move(answer);
  return absl::OkStatus();
}

absl::Status PostgresStatement::Ask() {
  wants_answer_ = true;
  answer_.reset();
  absl::Status status = connection_.Send(*this);
  if (status.ok()) status = connection_.Settle();
  wants_answer_ = false;
  return status;
}

absl::StatusOr<bool> PostgresStatement::Step() {
  if (!is_stepping_) {
    if (absl::Status status = Ask(); !status.ok()) return status;
    is_stepping_ = true;
    row_ = -1;
  }
  return ++row_ < PQntuples(answer_.get());
}

absl::Status PostgresStatement::Run() {
  is_stepping_ = false;
  return connection_.Send(*this);
}

absl::StatusOr<int64_t> PostgresStatement::Change() {
  is_stepping_ = false;
  if (absl::Status status = Ask(); !status.ok()) return status;
  int64_t changed = 0;
  if (!absl::SimpleAtoi(PQcmdTuples(answer_.get()), &changed)) return 0;
  return changed;
}

void PostgresStatement::Reset() {
  is_stepping_ = false;
  answer_.reset();
  for (Parameter& parameter : parameters_) parameter = {};
}

int64_t PostgresStatement::Int(int column) const {
  const int size = PQgetlength(answer_.get(), row_, column);
  const uint64_t value = FromBigEndian(PQgetvalue(answer_.get(), row_, column), size);
  return size == sizeof(int32_t) ? static_cast<int32_t>(value) : static_cast<int64_t>(value);
}

double PostgresStatement::Real(int column) const {
  if (PQftype(answer_.get(), column) != kFloat64) return static_cast<double>(Int(column));
  return std::bit_cast<double>(
      FromBigEndian(PQgetvalue(answer_.get(), row_, column), sizeof(double)));
}

bool PostgresStatement::IsNull(int column) const {
  return PQgetisnull(answer_.get(), row_, column) == 1;
}

std::string PostgresStatement::Text(int column) const {
  return std::string(PQgetvalue(answer_.get(), row_, column),
                     static_cast<size_t>(PQgetlength(answer_.get(), row_, column)));
}

}  // namespace isthmus::storage
