#include "client/console/words.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <numeric>
#include <string_view>

namespace isthmus::cli {
namespace {

constexpr char kHelp[] = "help";

bool IsOption(std::string_view word) { return word.starts_with('-'); }

// Number of words of an option that may stand before the command, itself included; 0: it is none.
size_t ServerOptionWords(std::string_view word) {
  for (const std::string_view name : {"--server", "--attempts", "--tls-ca", "--tls-cert",
                                      "--tls-key", "--token-file", "--site"}) {
    if (word == name) return 2;
    if (word.starts_with(name) && word[name.size()] == '=') return 1;
  }
  return 0;
}

// The first word that is no option.
size_t FirstPlainWord(const std::vector<std::string>& words, size_t from) {
  while (from < words.size() && IsOption(words[from])) {
    from += std::max<size_t>(ServerOptionWords(words[from]), 1);
  }
  return std::min(from, words.size());
}

const CLI::App* Below(const CLI::App& app, const std::string& name) {
  const auto found =
      app.get_subcommands([&name](const CLI::App* one) { return one->get_name() == name; });
  return found.empty() ? nullptr : found.front();
}

// Levenshtein's: letters to insert, remove or replace.
size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0]++;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, replaced});
    }
  }
  return row.back();
}

// Empty where more than half of the word would have to change.
std::string Nearest(const std::string& word, const CLI::App& app) {
  std::string nearest;
  size_t least = word.size() / 2 + 1;
  for (const CLI::App* one : app.get_subcommands([](const CLI::App*) { return true; })) {
    const size_t distance = EditDistance(word, one->get_name());
    if (distance >= least) continue;
    least = distance;
    nearest = one->get_name();
  }
  return nearest;
}

// CLI11 would speak of a command that is missing alone, where one is.
absl::Status CheckOption(const std::string& word, const CLI::App& app, const std::string& path) {
  const std::string name = word.substr(0, word.find('='));
  if (ServerOptionWords(word) > 0 || app.get_option_no_throw(name) != nullptr) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat("there is no option ", name, " of `isthmus", path,
                                                 "`. `isthmus help", path,
                                                 "` lists what there is"));
}

}  // namespace

size_t CommandAt(const std::vector<std::string>& words) {
  const size_t first = FirstPlainWord(words, 0);
  const bool is_help = first < words.size() && words[first] == kHelp;
  return is_help ? FirstPlainWord(words, first + 1) : first;
}

std::vector<std::string> Arranged(const std::vector<std::string>& words, const CLI::App& app) {
  const size_t command = CommandAt(words);
  std::vector<std::string> out, moved;
  bool asks_for_help = false;
  for (size_t i = 0; i < command; ++i) {
    if (!IsOption(words[i])) {
      asks_for_help = true;  // Only "help" is a plain word there.
    } else if (const size_t taken = ServerOptionWords(words[i]); taken == 0) {
      out.push_back(words[i]);
    } else {
      const size_t end = std::min(i + taken, words.size());
      moved.insert(moved.end(), words.begin() + i, words.begin() + end);
      i = end - 1;
    }
  }
  size_t at = command;
  for (const CLI::App* below = &app; at < words.size(); ++at) {
    below = Below(*below, words[at]);
    if (below == nullptr) break;
    out.push_back(words[at]);
  }
  out.insert(out.end(), moved.begin(), moved.end());
  if (asks_for_help) out.emplace_back("--help");
  out.insert(out.end(), words.begin() + at, words.end());
  return out;
}

absl::Status CheckCommand(const std::vector<std::string>& words, const CLI::App& app) {
  std::string path;
  const CLI::App* below = &app;
  const size_t command = CommandAt(words);
  for (size_t at = 0; at < command; at += std::max<size_t>(ServerOptionWords(words[at]), 1)) {
    if (!IsOption(words[at])) continue;
    if (absl::Status status = CheckOption(words[at], app, path); !status.ok()) return status;
  }
  for (size_t at = command; at < words.size(); ++at) {
    const std::string& word = words[at];
    const CLI::App* next = Below(*below, word);
    if (next != nullptr) {
      below = next;
      absl::StrAppend(&path, " ", word);
      continue;
    }
    if (below->get_require_subcommand_min() == 0) break;
    if (IsOption(word)) return CheckOption(word, *below, path);
    const std::string nearest = Nearest(word, *below);
    return absl::InvalidArgumentError(
        absl::StrCat("there is no command `isthmus", path, " ", word, "`",
                     nearest.empty() ? "." : absl::StrCat("; did you mean `", nearest, "`?"),
                     " `isthmus help", path, "` lists the commands"));
  }
  return absl::OkStatus();
}

}  // namespace isthmus::cli
