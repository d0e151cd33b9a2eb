// A fuzzer without a fuzzer: gives it each file of a folder, so that tests keep what was found.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>

#include "core/io/file_io.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

int main(int argc, char** argv) {
  int files = 0;
  for (const auto& file : std::filesystem::directory_iterator(argc > 1 ? argv[1] : ".")) {
    const absl::StatusOr<std::string> bytes = isthmus::io::ReadFile(file.path());
    if (!bytes.ok()) return 1;
    std::printf("%s\n", file.path().c_str());
    std::fflush(stdout);  // The last one is the one that crashed.
    LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(bytes->data()), bytes->size());
    ++files;
  }
  return files > 0 ? 0 : 1;
}
