// One command line in several programs: `isthmus` finds those that need no server.
#include <absl/strings/str_split.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "client/console/offline_commands.h"
#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

// A copy of `isthmus` where nothing else is, in FOLDER/bin.
fs::path AloneIn(const fs::path& folder) {
  fs::create_directories(folder / "bin");
  fs::copy_file(ISTHMUS_PROGRAM, folder / "bin/isthmus");
  return folder / "bin/isthmus";
}

TEST(OfflineProgram, WhereItIsNotInstalledTheMessageNamesItsPackage) {
  const fs::path folder = ScratchFolder();
  const std::string isthmus = AloneIn(folder);
  for (const OfflineCommand& command : OfflineCommands()) {
    const ProgramResult result = RunProgram(isthmus, std::string(command.name) + " --help");
    EXPECT_EQ(result.code, 1) << command.name;
    EXPECT_THAT(result.err,
                AllOf(HasSubstr(std::string(command.program)), HasSubstr("Debian package"),
                      HasSubstr((folder / "libexec/isthmus").string())));
  }
  const ProgramResult help = RunProgram(isthmus, "--help");
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.out, HasSubstr("  merge ")) << "it is listed all the same";
  EXPECT_EQ(RunProgram(isthmus, "push --help").code, 0) << "the others need nothing of it";
  fs::remove_all(folder);
}

TEST(OfflineProgram, IsFoundInLibexec) {
  const fs::path folder = ScratchFolder();
  const std::string isthmus = AloneIn(folder);
  fs::create_directories(folder / "libexec/isthmus");
  fs::create_symlink(OFFLINE_PROGRAM, folder / "libexec/isthmus/isthmus-offline");
  const ProgramResult help = RunProgram(isthmus, "merge --help");
  EXPECT_EQ(help.code, 0) << help.err;
  EXPECT_THAT(help.out, HasSubstr("Usage: isthmus merge "));
  EXPECT_EQ(RunProgram(isthmus, "merge one.pcd -o merged.pcd").code, 2)
      << "its exit code is passed on";
  fs::remove_all(folder);
}

TEST(OfflineProgram, WhatCannotBeRunIsSaid) {
  const fs::path folder = ScratchFolder();
  const std::string isthmus = AloneIn(folder);
  fs::create_directory(folder / "bin/isthmus-offline");
  const ProgramResult result = RunProgram(isthmus, "merge --help");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("Permission denied"));
  fs::remove_all(folder);
}

// The help of `program` below the heading, line by line, up to an empty one.
std::vector<std::string> LinesBelow(const std::string& heading, const std::string& program) {
  const std::string help = RunProgram(program, "--help").out;
  const size_t at = help.find(heading);
  EXPECT_NE(at, std::string::npos) << program << "\n" << help;
  if (at == std::string::npos) return {};
  const size_t begin = at + heading.size();
  return absl::StrSplit(help.substr(begin, help.find("\n\n", begin) - begin), '\n',
                        absl::SkipEmpty());
}

TEST(OfflineProgram, DescribesItsCommandsAsIsthmusDoes) {
  std::set<std::string> programs;
  for (const OfflineCommand& command : OfflineCommands()) programs.emplace(command.program);
  std::vector<std::string> all;
  for (const std::string& program : programs) {
    const fs::path path = fs::path(ISTHMUS_PROGRAM).parent_path() / program;
    const auto lines = LinesBelow("Subcommands:\n", path);
    all.insert(all.end(), lines.begin(), lines.end());
  }
  EXPECT_THAT(LinesBelow("Subcommands that need no server:\n", ISTHMUS_PROGRAM),
              testing::UnorderedElementsAreArray(all));
}

TEST(OfflineProgram, OptionsBeforeTheCommandReachIt) {
  EXPECT_THAT(Isthmus("--help eval").out, HasSubstr("Usage: isthmus eval "));
}

TEST(OfflineProgram, AWordThatOnlyLooksLikeItsCommandIsLeftAlone) {
  const ProgramResult push = Isthmus("push --robot merge --sensor vlp16 merge");
  EXPECT_EQ(push.code, 5);
  EXPECT_THAT(push.err, HasSubstr("merge does not exist"));
}

}  // namespace
}  // namespace isthmus::cli
