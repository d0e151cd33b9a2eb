// The words of a command line, as a person may order them and as commands take them.
#pragma once

#include <absl/status/status.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstddef>
#include <string>
#include <vector>

namespace isthmus::cli {

// The place of the command: the first word that is neither an option, nor the value of one that may
// stand before the command, nor `help` before another word. As many as there are words if none is.
size_t CommandAt(const std::vector<std::string>& words);

// In the order that `app` parses: `help match set` becomes `match set --help`, and --server and
// --attempts that stand before the command go behind it.
std::vector<std::string> Arranged(const std::vector<std::string>& words, const CLI::App& app);

// InvalidArgument, with the command that is spelt most like it, where a word stands in the place of
// a command and is none.
absl::Status CheckCommand(const std::vector<std::string>& words, const CLI::App& app);

}  // namespace isthmus::cli
