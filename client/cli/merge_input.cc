#include "client/cli/merge_input.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>

#include <cmath>
#include <filesystem>
#include <set>
#include <utility>

#include "core/codec/payload_layout.h"
#include "core/codec/pcd.h"

namespace isthmus::cli {
namespace {

// What the server takes in one submap; see kMaxScanPoints.
constexpr size_t kMaxSubmapPoints = 2'000'000;

std::string RobotName(const std::string& file, std::set<std::string>& taken) {
  std::string name = std::filesystem::path(file).stem().string().substr(0, 56);
  for (char& c : name) {
    if (!absl::ascii_isalnum(c) && c != '_' && c != '.' && c != '-') c = '_';
  }
  if (name.empty()) name = "map";
  std::string unique = name;
  for (int i = 2; !taken.insert(unique).second; ++i) unique = absl::StrCat(name, "-", i);
  return unique;
}

}  // namespace

absl::StatusOr<std::vector<PointPayload>> SplitFinite(const PointPayload& raw, size_t max_points) {
  if (absl::Status status = codec::CheckRawLayout(raw); !status.ok()) return status;
  std::vector<std::vector<double>> xyz;
  for (const char* name : {"x", "y", "z"}) {
    const PointField* field = codec::FindField(raw, {name});
    if (field == nullptr) return absl::InvalidArgumentError(absl::StrCat("no field ", name));
    xyz.push_back(codec::ReadColumn(raw, *field));
  }
  PointPayload empty = raw;
  empty.data.clear();
  empty.width = 0;
  empty.height = 1;
  std::vector<PointPayload> parts;
  for (size_t i = 0; i < xyz[0].size(); ++i) {
    if (!std::isfinite(xyz[0][i] + xyz[1][i] + xyz[2][i])) continue;
    if (parts.empty() || parts.back().width == max_points) parts.push_back(empty);
    parts.back().data.append(raw.data, i * raw.stride, raw.stride);
    ++parts.back().width;
  }
  if (parts.empty()) return absl::InvalidArgumentError("no point with finite coordinates");
  return parts;
}

absl::StatusOr<std::vector<MergeInput>> ReadMergeInputs(const std::vector<std::string>& files) {
  std::vector<MergeInput> inputs;
  std::set<std::string> names;
  for (const std::string& file : files) {
    absl::StatusOr<codec::PcdFile> pcd = codec::ReadPcd(file);
    if (!pcd.ok()) return pcd.status();
    absl::StatusOr<std::vector<PointPayload>> parts = SplitFinite(pcd->payload, kMaxSubmapPoints);
    if (!parts.ok()) {
      return absl::InvalidArgumentError(absl::StrCat(file, ": ", parts.status().message()));
    }
    MergeInput input;
    input.file = file;
    input.robot = RobotName(file, names);
    for (PointPayload& part : *parts) {
      client::SubmapUpload submap;
      submap.keyframes = {{0, pcd->viewpoint}};
      input.points += part.width;
      submap.cloud = std::move(part);
      input.submaps.push_back(std::move(submap));
    }
    inputs.push_back(std::move(input));
  }
  return inputs;
}

}  // namespace isthmus::cli
