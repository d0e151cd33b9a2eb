#include "client/console/numbers.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

namespace isthmus::cli {
namespace {

CLI::Validator Above(double least, bool itself, const char* name, const char* wanted) {
  const auto why_not = [=](const std::string& text) -> std::string {
    double number = 0;
    int64_t whole = 0;
    const bool is_whole = text.find_first_not_of("+-0123456789") == std::string::npos;
    if (!absl::SimpleAtod(text, &number) || std::isnan(number)) {
      return absl::StrCat("\"", text, "\" is not a number");
    }
    if (!std::isfinite(number) || (is_whole && !absl::SimpleAtoi(text, &whole))) {
      return absl::StrCat(text, " is too large a number");
    }
    if (number > least || (itself && number == least)) return "";
    return absl::StrCat("give a number ", wanted, ", not ", text);
  };
  return CLI::Validator([why_not](std::string& text) { return why_not(text); }, name);
}

}  // namespace

CLI::Validator Positive() { return Above(0, false, "POSITIVE", "above 0"); }

CLI::Validator NotNegative() { return Above(0, true, "NONNEGATIVE", "from 0 on"); }

}  // namespace isthmus::cli
