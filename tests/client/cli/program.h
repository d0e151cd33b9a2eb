// The built `isthmus`, run as a user does.
#pragma once

#include <string>

namespace isthmus::cli {

struct ProgramResult {
  int code = -1;
  std::string out, err;
};

// Arguments as a shell takes them. Without ISTHMUS_SERVER in the environment.
ProgramResult Isthmus(const std::string& arguments);
ProgramResult RunProgram(const std::string& program, const std::string& arguments);

// A folder of the running test's own, empty.
std::string ScratchFolder();

}  // namespace isthmus::cli
