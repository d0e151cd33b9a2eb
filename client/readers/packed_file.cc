#include "client/readers/packed_file.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>

#include <filesystem>
#include <fstream>

#include "client/readers/shell_word.h"

namespace isthmus::readers {
namespace {

namespace fs = std::filesystem;

struct Packer {
  absl::string_view magic;
  const char* ending;
  const char* command;      // Unpacks a file.
  const char* tar_command;  // Unpacks a packed archive.
};

constexpr Packer kPackers[] = {
    {"\x1F\x8B\x08", ".gz", "gunzip -k", "tar -xzf"},
    {"BZh", ".bz2", "bunzip2 -k", "tar -xjf"},
    {absl::string_view("\xFD"
                       "7zXZ\0",
                       6),
     ".xz", "unxz -k", "tar -xJf"},
    {"\x28\xB5\x2F\xFD", ".zst", "zstd -d", "tar --zstd -xf"},
    {"\x28\xB5\x2F\xFD", ".zstd", "zstd -d", "tar --zstd -xf"},
    {"\x04\x22\x4D\x18", ".lz4", "lz4 -dk", "tar -I lz4 -xf"},
    {"PK\x03\x04", ".zip", "unzip", "unzip"},
    {"7z\xBC\xAF\x27\x1C", ".7z", "7z x", "7z x"},
};

constexpr size_t kTarMagicAt = 257;  // Format
constexpr absl::string_view kTarMagic = "ustar";

bool IsArchive(const std::string& path, const Packer& packer) {
  return absl::EndsWith(path, absl::StrCat(".tar", packer.ending)) ||
         absl::EndsWith(path, ".tgz") || absl::EndsWith(path, ".tbz2") ||
         absl::EndsWith(path, ".txz");
}

std::string CommandOfFile(const std::string& path) {
  std::string first(kTarMagicAt + kTarMagic.size(), '\0');
  std::ifstream(path, std::ios::binary)
      .read(first.data(), static_cast<std::streamsize>(first.size()));
  if (absl::EndsWith(first, kTarMagic)) return absl::StrCat("tar -xf ", ShellWord(path));
  for (const Packer& packer : kPackers) {
    if (!absl::StartsWith(first, packer.magic)) continue;
    return absl::StrCat(IsArchive(path, packer) ? packer.tar_command : packer.command, " ",
                        ShellWord(path));
  }
  return "";
}

std::string CommandOfFolder(const std::string& path) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(path, error)) {
    std::error_code ignored;
    const std::string name = entry.path().filename().string();
    if (name.front() == '.' || !entry.is_regular_file(ignored)) continue;
    for (const Packer& packer : kPackers) {
      if (!absl::EndsWith(name, packer.ending)) continue;
      // One name at a time is what tar, unzip and 7z take.
      const std::string command = CommandOfFile(entry.path().string());
      if (command.empty() || !absl::StartsWith(command, packer.command)) return command;
      const bool takes_many = absl::string_view(packer.command) != packer.tar_command;
      return takes_many ? absl::StrCat(packer.command, " ", ShellWord(path), "/*", packer.ending)
                        : command;
    }
  }
  return "";
}

}  // namespace

std::string UnpackCommand(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return CommandOfFolder(path);
  return fs::is_regular_file(path, error) ? CommandOfFile(path) : "";
}

}  // namespace isthmus::readers
