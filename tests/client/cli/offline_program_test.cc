// One command line in two programs: `isthmus` finds the one that needs no server.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

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
    EXPECT_THAT(result.err, AllOf(HasSubstr("isthmus-offline"), HasSubstr("Debian package"),
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
  const ProgramResult result = RunProgram(isthmus, "simulate --help");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("Permission denied"));
  fs::remove_all(folder);
}

TEST(OfflineProgram, DescribesItsCommandsAsIsthmusDoes) {
  const ProgramResult all = Isthmus("--help");
  const ProgramResult offline = RunProgram(OFFLINE_PROGRAM, "--help");
  ASSERT_EQ(offline.code, 0);
  const std::string heading = "Subcommands:\n", place = "Subcommands that need no server:\n";
  const size_t at = offline.out.find(heading);
  ASSERT_NE(at, std::string::npos) << offline.out;
  EXPECT_THAT(all.out, HasSubstr(place + offline.out.substr(at + heading.size())));
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
