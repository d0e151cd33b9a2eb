#include "client/console/numbers.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

namespace isthmus::cli {
namespace {

// Why this is no number for us; empty where it is one.
std::string WhyNot(const std::string& text, double* number) {
  int64_t whole = 0;
  const bool is_whole = text.find_first_not_of("+-0123456789") == std::string::npos;
  if (!absl::SimpleAtod(text, number) || std::isnan(*number)) {
    return absl::StrCat("\"", text, "\" is not a number");
  }
  if (!std::isfinite(*number) || (is_whole && !absl::SimpleAtoi(text, &whole))) {
    return absl::StrCat(text, " is too large a number");
  }
  return "";
}

// `name` is that of the values in the help; `wanted` follows "a number".
CLI::Validator Number(const std::function<bool(double)>& is_good, std::string name,
                      const std::string& wanted) {
  const auto check = [=](const std::string& text) -> std::string {
    double number = 0;
    std::string why = WhyNot(text, &number);
    if (!why.empty() || is_good(number)) return why;
    return absl::StrCat("give a number ", wanted, ", not ", text);
  };
  return CLI::Validator([check](std::string& text) { return check(text); }, std::move(name));
}

}  // namespace

CLI::Validator Finite() {
  return Number([](double) { return true; }, "NUMBER", "");
}

CLI::Validator Positive() {
  return Number([](double number) { return number > 0; }, "POSITIVE", "above 0");
}

CLI::Validator NotNegative() {
  return Number([](double number) { return number >= 0; }, "NONNEGATIVE", "from 0 on");
}

CLI::Validator Between(double least, double most) {
  return Number([=](double number) { return number >= least && number <= most; },
                absl::StrCat("[", least, " - ", most, "]"),
                absl::StrCat("from ", least, " to ", most));
}

}  // namespace isthmus::cli
