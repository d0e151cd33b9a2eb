// isthmus copy, between folders; tests/fleet/postgresql has the databases.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "storage/sqlite/sqlite_store.h"
#include "tests/client/cli/program.h"
#include "tests/storage/records.h"

namespace isthmus::cli {
namespace {

TEST(Copy, TheCommandSaysWhatItDidAndWhatIsWrong) {
  const std::string folder = ScratchFolder();
  const std::string from = folder + "/from", to = folder + "/to";
  EXPECT_EQ(Isthmus("copy " + from).code, 2);
  EXPECT_EQ(Isthmus("copy " + from + " " + to).code, 5);  // No map there.
  EXPECT_EQ(Isthmus("copy postgresql://me:secret@host/db " + to).code, 5);
  {
    const auto store = storage::OpenSqliteStore(from).value();
    ASSERT_TRUE(store
                    ->Write({.sessions = {storage::MakeSession("alice-1")},
                             .submaps = {storage::MakeSubmap("alice-1", 0)}})
                    .ok());
    EXPECT_EQ(Isthmus("copy " + from + " " + to).code, 5);  // In use.
  }
  const ProgramResult result = Isthmus("copy " + from + " " + to + " --json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out)["submaps"], 1);
  EXPECT_EQ(storage::OpenSqliteStore(to).value()->ListSubmaps(std::nullopt)->size(), 1u);
  EXPECT_EQ(Isthmus("copy " + from + " " + to).code, 5);  // There is one already.
}

}  // namespace
}  // namespace isthmus::cli
