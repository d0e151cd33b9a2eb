// A statement as libpq takes it: parameters and answers in PostgreSQL's binary form.
#pragma once

#include <libpq-fe.h>

#include <memory>
#include <string>
#include <vector>

#include "fleet/postgresql/postgresql.h"

namespace isthmus::storage {

struct ResultDeleter {
  void operator()(PGresult* result) const { PQclear(result); }
};
using Result = std::unique_ptr<PGresult, ResultDeleter>;

// The error that a result or its connection reports; OK for a result that is none.
absl::Status StatusOf(const PGresult* result);

class PostgresStatement : public CompiledStatement {
 public:
  PostgresStatement(PostgresConnection& connection, const std::string& sql);

  absl::Status BindNumber(int parameter, int64_t value) override;
  absl::Status BindReal(int parameter, double value) override;
  absl::Status BindText(int parameter, const std::string& text) override;
  absl::Status BindBlob(int parameter, const std::string& bytes) override;
  absl::Status BindNull(int parameter) override;
  absl::StatusOr<bool> Step() override;
  absl::Status Run() override;
  absl::StatusOr<int64_t> Change() override;
  void Reset() override;
  int64_t Int(int column) const override;
  double Real(int column) const override;
  bool IsNull(int column) const override;
  std::string Text(int column) const override;

  // For the connection. The first sends the missing part of preparation and execution; false when
  // the way is lost.
  bool SendPreparation(PGconn* connection, const std::string& name);
  bool SendExecution(PGconn* connection) const;
  // Internal for an answer with a column that Int, Real and Text cannot read.
  absl::Status Take(Result answer);
  bool wants_answer() const { return wants_answer_; }
  std::string Tag() const { return answer_ ? PQcmdStatus(answer_.get()) : ""; }

  // The connection on which it is prepared, as the connection counts them; 0: on none.
  int64_t prepared_on = 0;

 private:
  struct Parameter {
    Oid type = 0;  // 0: NULL of any type.
    std::string bytes;
  };
  absl::Status Bind(int parameter, Oid type, std::string bytes);
  absl::Status Ask();  // Sends, and waits for the answer.

  PostgresConnection& connection_;
  std::string sql_;   // With $1, $2 ... for its parameters.
  std::string name_;  // As prepared last.
  std::vector<Parameter> parameters_;
  bool wants_answer_ = false;
  bool is_stepping_ = false;
  Result answer_;
  int row_ = -1;
};

}  // namespace isthmus::storage
