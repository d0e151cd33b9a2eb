// Checks of what somebody wrote on a command line, the same for all programs.
#pragma once

#include <absl/status/status.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <string>
#include <vector>

namespace isthmus {

// The words behind the program's name.
std::vector<std::string> Words(int argc, const char* const* argv);

// InvalidArgument for a word that is not UTF-8, unless it is the name of a file that is there:
// names and notes travel in messages, which hold nothing else.
absl::Status CheckText(const std::vector<std::string>& words);

// InvalidArgument for an option with an empty value, such as a variable of the shell that is not
// set leaves: it would have no effect, in silence. `app` has parsed the words.
absl::Status CheckValues(const std::vector<std::string>& words, const CLI::App& app);

}  // namespace isthmus
