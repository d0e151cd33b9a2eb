// Words of a command that a user is given.
#pragma once

#include <string>

namespace isthmus::readers {

// As a shell takes it for one word: in quotes where it has spaces or signs.
std::string ShellWord(const std::string& word);

}  // namespace isthmus::readers
