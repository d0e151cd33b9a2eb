#include "client/readers/folder/scan_folder.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "client/readers/folder/times_file.h"
#include "core/codec/payload_layout.h"
#include "core/formats/kitti_bin.h"
#include "core/formats/pcd.h"
#include "core/io/file_io.h"

namespace isthmus::readers {
namespace {

namespace fs = std::filesystem;

absl::Status WithPath(const absl::Status& status, const std::string& path) {
  if (status.ok() || std::string(status.message()).find(path) != std::string::npos) return status;
  return absl::Status(status.code(), absl::StrCat(path, ": ", status.message()));
}

absl::StatusOr<std::vector<fs::path>> ListScans(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return absl::NotFoundError(absl::StrCat(folder.string(), " is not a folder of scans"));
  }
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string extension = entry.path().extension();
    if (extension == ".bin" || extension == ".pcd") files.push_back(entry.path());
  }
  if (error) {
    return absl::UnavailableError(
        absl::StrCat("cannot list ", folder.string(), ": ", error.message()));
  }
  if (files.empty()) {
    return absl::NotFoundError(
        absl::StrCat(folder.string(), " holds no scans: no .bin and no .pcd files"));
  }
  // 10.pcd comes after 9.pcd.
  const auto key = [](const fs::path& file) {
    uint64_t number = 0;
    const std::string stem = file.stem();
    const bool numbered = absl::SimpleAtoi(stem, &number);
    return std::make_tuple(!numbered, number, stem, file.extension().string());
  };
  std::sort(files.begin(), files.end(),
            [&](const fs::path& a, const fs::path& b) { return key(a) < key(b); });
  return files;
}

// The file of that name in the folder, else beside it.
std::optional<fs::path> Find(const fs::path& folder, const char* name) {
  std::error_code error;
  const fs::path whole = fs::absolute(folder, error).lexically_normal();
  // "scans/" has an empty last component.
  const fs::path beside = (whole.has_filename() ? whole : whole.parent_path()).parent_path();
  for (const fs::path& place : {whole, beside}) {
    if (fs::is_regular_file(place / name, error)) return place / name;
  }
  return std::nullopt;
}

absl::StatusOr<std::vector<int64_t>> Stamps(const fs::path& folder, size_t scans, double rate_hz) {
  if (const std::optional<fs::path> file = Find(folder, "times.txt")) {
    absl::StatusOr<std::string> text = io::ReadFile(*file);
    if (!text.ok()) return text.status();
    absl::StatusOr<std::vector<int64_t>> stamps = ParseTimes(*text);
    if (!stamps.ok()) return WithPath(stamps.status(), *file);
    if (stamps->size() == scans) return stamps;
    return absl::InvalidArgumentError(absl::StrCat(file->string(), " has ", stamps->size(),
                                                   " times for ", scans, " scans in ",
                                                   folder.string()));
  }
  std::vector<int64_t> stamps(scans);
  for (size_t i = 0; i < scans; ++i) {
    stamps[i] = std::llround(static_cast<double>(i) * 1e9 / rate_hz);
  }
  return stamps;
}

}  // namespace

absl::StatusOr<ScanFolder> ScanFolder::Open(const std::string& path,
                                            const ScanFolderOptions& options) {
  if (!(options.rate_hz > 0) || !std::isfinite(options.rate_hz)) {
    return absl::InvalidArgumentError("the rate must be positive");
  }
  absl::StatusOr<std::vector<fs::path>> files = ListScans(path);
  if (!files.ok()) return files.status();
  ScanFolder folder;
  folder.path_ = path;
  folder.kitti_ = files->front().extension() == ".bin";
  for (const fs::path& file : *files) {
    if ((file.extension() == ".bin") == folder.kitti_) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(path, " holds both .bin and .pcd files: which ones are the scans?"));
  }
  absl::StatusOr<std::vector<int64_t>> stamps = Stamps(path, files->size(), options.rate_hz);
  if (!stamps.ok()) return stamps.status();
  const size_t last = std::min(options.to.value_or(files->size() - 1), files->size() - 1);
  if (options.from > last) {
    return absl::InvalidArgumentError(absl::StrCat("no scans from ", options.from, " to ", last,
                                                   ": ", path, " holds ", files->size()));
  }
  for (size_t i = options.from; i <= last; ++i) {
    folder.files_.push_back((*files)[i]);
    folder.stamps_ns_.push_back((*stamps)[i]);
  }
  return folder;
}

absl::StatusOr<PointPayload> ScanFolder::Read(size_t i) const {
  if (kitti_) {
    absl::StatusOr<PointPayload> payload = formats::ReadKittiBin(files_[i]);
    if (!payload.ok()) return WithPath(payload.status(), files_[i]);
    return payload;
  }
  absl::StatusOr<formats::PcdFile> pcd = formats::ReadPcd(files_[i]);
  if (!pcd.ok()) return WithPath(pcd.status(), files_[i]);
  return std::move(pcd->payload);
}

absl::StatusOr<std::string> ScanFolder::GuessSensor() const {
  if (const std::optional<fs::path> file = Find(path_, "simulation.json")) {
    absl::StatusOr<std::string> text = io::ReadFile(*file);
    if (!text.ok()) return text.status();
    const auto json = nlohmann::json::parse(*text, nullptr, /*allow_exceptions=*/false);
    if (json.is_object() && json.contains("sensor") && json["sensor"].is_string()) {
      return json["sensor"].get<std::string>();
    }
  }
  if (kitti_) return "hdl64";
  absl::StatusOr<PointPayload> first = Read(0);
  if (!first.ok()) return first.status();
  const PointField* ring = codec::FindField(*first, {"ring", "channel", "line", "row", "laser_id"});
  double highest = first->height > 1 ? first->height - 1.0 : -1;
  if (ring != nullptr) {
    for (const double value : codec::ReadColumn(*first, *ring)) highest = std::max(highest, value);
  }
  if (highest < 0 || highest >= 128) {
    return absl::NotFoundError(
        absl::StrCat("cannot tell the sensor from ", files_[0], ": name it with --sensor"));
  }
  return highest < 16 ? "vlp16" : highest < 32 ? "hdl32" : highest < 64 ? "hdl64" : "os1-128";
}

}  // namespace isthmus::readers
