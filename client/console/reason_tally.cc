#include "client/console/reason_tally.h"

#include <cctype>

namespace isthmus::cli {
namespace {

constexpr uint64_t kSaid = 3;  // Per kind: enough to see what the reasons have in common.

std::string WithoutNumbers(const std::string& reason) {
  std::string out;
  for (const char letter : reason) {
    if (std::isdigit(static_cast<unsigned char>(letter)) == 0) {
      out += letter;
    } else if (out.empty() || out.back() != '#') {
      out += '#';
    }
  }
  return out;
}

}  // namespace

bool ReasonTally::Count(const std::string& reason) {
  Kind& kind = kinds_[WithoutNumbers(reason)];
  kind.last = reason;
  return ++kind.count <= kSaid;
}

std::vector<std::pair<std::string, uint64_t>> ReasonTally::Unsaid() const {
  std::vector<std::pair<std::string, uint64_t>> out;
  for (const auto& [ignored, kind] : kinds_) {
    if (kind.count > kSaid) out.emplace_back(kind.last, kind.count - kSaid);
  }
  return out;
}

}  // namespace isthmus::cli
