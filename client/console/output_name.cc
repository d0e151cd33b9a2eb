#include "client/console/output_name.h"

namespace isthmus::cli {

CLI::Validator OutputNamed(const std::vector<std::string>& extensions) {
  const auto check = [extensions](const std::string& path) {
    return std::string(CheckOutputName(path, extensions).message());
  };
  return CLI::Validator([check](std::string& path) { return check(path); }, "");
}

}  // namespace isthmus::cli
