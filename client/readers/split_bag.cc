#include "client/readers/split_bag.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "client/readers/folder/name_series.h"
#include "client/readers/messages/joined_file.h"

namespace isthmus::readers {
namespace {

namespace fs = std::filesystem;

// In the order of their last numbers; empty unless these are 0, 1, 2 and so on, or go on so from
// another number. A part that is still being written, or was, has an ending of its own.
std::vector<std::string> PartsInOrder(const std::vector<std::string>& bags) {
  std::vector<std::pair<std::string, std::string>> numbered;  // Number, padded, and name.
  std::string first_text;
  for (const std::string& bag : bags) {
    const std::string stem = bag.substr(0, bag.rfind(".bag"));
    const NameParts parts = CutName(stem);
    const bool counts = !parts.numbers.empty() && parts.texts.back().empty() &&
                        parts.numbers.back().fraction.empty();
    if (!counts) return {};
    if (numbered.empty()) first_text = parts.texts.front();
    if (parts.texts.front() != first_text) return {};
    std::string number = parts.numbers.back().digits;
    if (number.size() < 9) number.insert(0, 9 - number.size(), '0');
    numbered.emplace_back(std::move(number), bag);
  }
  std::sort(numbered.begin(), numbered.end());
  std::vector<std::string> counted;
  for (const auto& [number, name] : numbered) counted.push_back(absl::StrCat(number, ".bag"));
  const std::vector<int64_t> counts = FindSeries(counted).Counts();
  std::vector<std::string> names;
  for (size_t i = 0; i < numbered.size(); ++i) {
    if (i >= counts.size() || counts[i] != counts[0] + static_cast<int64_t>(i)) return {};
    names.push_back(numbered[i].second);
  }
  return names;
}

}  // namespace

std::vector<std::string> ListBags(const std::string& folder) {
  std::vector<std::string> bags;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    std::error_code ignored;
    const std::string name = entry.path().filename().string();
    const bool is_bag = absl::EndsWith(name, ".bag") || absl::EndsWith(name, ".bag.active");
    if (is_bag && name.front() != '.' && entry.is_regular_file(ignored)) bags.push_back(name);
  }
  std::sort(bags.begin(), bags.end());
  return bags;
}

absl::StatusOr<std::shared_ptr<const MessageFile>> OpenSplitBag(
    const std::string& folder, const std::vector<std::string>& bags) {
  const auto path = [&](const std::string& bag) { return (fs::path(folder) / bag).string(); };
  if (bags.size() == 1) return OpenMessageFile(path(bags[0]));
  const std::vector<std::string> parts = PartsInOrder(bags);
  if (parts.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        folder, " holds several bags, which may be of several drives: ", absl::StrJoin(bags, ", "),
        ". Give one of them; only files that end in _0.bag, _1.bag and so on are parts of one "
        "drive"));
  }
  std::vector<std::shared_ptr<const MessageFile>> files;
  std::vector<std::string> notes = {absl::StrCat("its ", parts.size(),
                                                 " bags are read as one drive, from ",
                                                 parts.front(), " to ", parts.back())};
  for (const std::string& part : parts) {
    auto file = OpenMessageFile(path(part));
    if (!file.ok()) return file.status();
    files.push_back(*std::move(file));
  }
  std::string kind = absl::StrCat(files.front()->kind(), ", split");
  return JoinFiles(std::move(files), std::move(kind), std::move(notes), {});
}

}  // namespace isthmus::readers
