#include "tests/client/cli/program.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace isthmus::cli {
namespace {

namespace fs = std::filesystem;

std::string Slurp(const fs::path& path) {
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

}  // namespace

ProgramResult Isthmus(const std::string& arguments) {
  return RunProgram(ISTHMUS_PROGRAM, arguments);
}

ProgramResult RunProgram(const std::string& program, const std::string& arguments) {
  const fs::path base = fs::path(testing::TempDir()) / ("isthmus_" + std::to_string(getpid()));
  const std::string out = base.string() + ".out", err = base.string() + ".err";
  const std::string command =
      "env -u ISTHMUS_SERVER " + program + " " + arguments + " >" + out + " 2>" + err;
  const int status = std::system(command.c_str());
  const ProgramResult result{WIFEXITED(status) ? WEXITSTATUS(status) : -1, Slurp(out), Slurp(err)};
  fs::remove(out);
  fs::remove(err);
  return result;
}

std::string ScratchFolder() {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  const std::string name = test != nullptr
                               ? std::string(test->test_suite_name()) + "." + test->name()
                               : std::string("suite");
  const fs::path folder =
      fs::path(testing::TempDir()) / "isthmus_cli" / (name + "." + std::to_string(getpid()));
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

}  // namespace isthmus::cli
