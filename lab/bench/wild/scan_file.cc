#include "lab/bench/wild/scan_file.h"

#include <absl/strings/str_cat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <filesystem>

#include "core/codec/byte_shuffle.h"
#include "core/codec/zstd_frame.h"
#include "core/io/file_io.h"

namespace isthmus::bench {
namespace {

constexpr char kMagic[8] = {'w', 'i', 'l', 'd', 's', 'c', 'a', '2'};

// Ends the file. Before it the title, before that the entries of all scans.
struct Tail {
  uint64_t entries = 0, title_bytes = 0;
  char magic[8] = {};
};

struct Column {
  size_t offset, width;
};

constexpr Column kColumns[] = {{offsetof(ScanPoint, x), 4},    {offsetof(ScanPoint, y), 4},
                               {offsetof(ScanPoint, z), 4},    {offsetof(ScanPoint, intensity), 4},
                               {offsetof(ScanPoint, time), 4}, {offsetof(ScanPoint, ring), 2}};
constexpr size_t kPointBytes = 22;

absl::Status Damaged(const std::string& path) {
  return absl::DataLossError(absl::StrCat(path, " is damaged; remove it to have it made again"));
}

}  // namespace

ScanFileWriter::ScanFileWriter(const std::string& path, const std::string& title)
    : path_(path),
      temporary_(absl::StrCat(path, ".", ::getpid())),
      title_(title),
      out_(temporary_, std::ios::binary) {}

absl::Status ScanFileWriter::Add(const Scan& scan, const Pose& T_world_sensor) {
  std::string planes(kPointBytes * scan.points.size(), '\0');
  size_t at = 0;
  for (const Column& column : kColumns) {
    const auto* first = reinterpret_cast<const char*>(scan.points.data());
    codec::Shuffle(first + column.offset, scan.points.size(), column.width, sizeof(ScanPoint),
                   planes.data() + at);
    at += column.width * scan.points.size();
  }
  std::string frame;
  if (auto status = codec::AppendZstdFrame(planes, frame, 1); !status.ok()) return status;
  ScanEntry& entry = entries_.emplace_back();
  entry = {written_,
           frame.size(),
           static_cast<uint32_t>(scan.points.size()),
           scan.has_ring,
           scan.has_time,
           scan.end_stamp_ns,
           {}};
  Eigen::Map<Eigen::Vector3d>(entry.pose) = T_world_sensor.translation();
  Eigen::Map<Eigen::Vector4d>(entry.pose + 3) = T_world_sensor.rotation().coeffs();
  out_ << frame;
  written_ += frame.size();
  return out_ ? absl::OkStatus() : io::FileError("write", temporary_, errno);
}

absl::Status ScanFileWriter::Finish() {
  Tail tail{entries_.size(), title_.size(), {}};
  std::memcpy(tail.magic, kMagic, sizeof(kMagic));
  out_.write(reinterpret_cast<const char*>(entries_.data()),
             static_cast<std::streamsize>(entries_.size() * sizeof(ScanEntry)));
  out_ << title_;
  out_.write(reinterpret_cast<const char*>(&tail), sizeof(tail));
  out_.close();
  if (!out_) return io::FileError("write", temporary_, errno);
  std::error_code error;
  std::filesystem::rename(temporary_, path_, error);
  return error ? io::FileError("write", path_, error.value()) : absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<ScanFile>> ScanFile::Open(const std::string& path) {
  auto file = std::make_shared<ScanFile>();
  file->path_ = path;
  const MutexLock lock(&file->mutex_);  // Nobody else knows it yet; clang cannot see that.
  file->in_.open(path, std::ios::binary);
  if (!file->in_) return io::FileError("read", path, errno);
  Tail tail;
  file->in_.seekg(-static_cast<std::streamoff>(sizeof(tail)), std::ios::end);
  const auto end = static_cast<int64_t>(file->in_.tellg());
  file->in_.read(reinterpret_cast<char*>(&tail), sizeof(tail));
  const auto entries_bytes = static_cast<int64_t>(tail.entries * sizeof(ScanEntry));
  const int64_t before = end - static_cast<int64_t>(tail.title_bytes) - entries_bytes;
  if (!file->in_ || std::memcmp(tail.magic, kMagic, sizeof(kMagic)) != 0 || before < 0) {
    return Damaged(path);
  }
  file->entries_.resize(tail.entries);
  file->title_.resize(tail.title_bytes);
  file->in_.seekg(before);
  file->in_.read(reinterpret_cast<char*>(file->entries_.data()), entries_bytes);
  file->in_.read(file->title_.data(), static_cast<std::streamsize>(tail.title_bytes));
  if (!file->in_) return Damaged(path);
  return file;
}

Pose ScanFile::Truth(int index) const {
  const double* pose = entries_[index].pose;
  return Pose(Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(pose + 3)),
              Eigen::Map<const Eigen::Vector3d>(pose));
}

absl::StatusOr<Scan> ScanFile::Read(int index) {
  const ScanEntry& entry = entries_[index];
  std::string frame(entry.bytes, '\0');
  {
    MutexLock lock(&mutex_);
    in_.seekg(static_cast<std::streamoff>(entry.offset));
    in_.read(frame.data(), static_cast<std::streamsize>(frame.size()));
    if (!in_) return Damaged(path_);
  }
  const auto planes = codec::ReadZstdFrame(frame.data(), frame.size(), kPointBytes * entry.points);
  if (!planes.ok()) return Damaged(path_);
  Scan scan;
  scan.sequence = static_cast<uint64_t>(index) + 1;
  scan.end_stamp_ns = entry.end_stamp_ns;
  scan.has_ring = entry.has_ring;
  scan.has_time = entry.has_time;
  scan.points.resize(entry.points);
  size_t at = 0;
  for (const Column& column : kColumns) {
    codec::Unshuffle(planes->data() + at, entry.points, column.width,
                     reinterpret_cast<char*>(scan.points.data()) + column.offset,
                     sizeof(ScanPoint));
    at += column.width * entry.points;
  }
  return scan;
}

}  // namespace isthmus::bench
