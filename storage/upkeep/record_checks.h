// The records of a database, read one by one to see which are damaged.
#pragma once

#include "storage/sql/connection.h"
#include "storage/upkeep/check_store.h"

namespace isthmus::storage {

void AddDamage(const std::string& record, const std::string& problem, StoreReport& report);

// Calls `visit` for each row of `sql`; where that ends early, `what` is damaged. Names of records
// and their values are fetched apart, so that one that cannot be read costs no others.
void ForEachRow(Connection& database, const std::string& what, const std::string& sql,
                StoreReport& report, const std::function<void(const Statement&)>& visit);

// `schema` is the database's. A row that cannot be read is damage, and no reason to stop.
void CheckSubmaps(Connection& database, int64_t schema, StoreReport& report);
void CheckSubmapNumbers(Connection& database, int64_t schema, StoreReport& report);
void CheckFeatures(Connection& database, StoreReport& report);
void CheckCheckpoints(Connection& database, StoreReport& report);
// Numbers that are missing in between, and kinds that are none.
void CheckEventLog(Connection& database, StoreReport& report);
void CheckEdges(Connection& database, int64_t schema, StoreReport& report);
void CheckPoses(Connection& database, int64_t schema, StoreReport& report);

}  // namespace isthmus::storage
