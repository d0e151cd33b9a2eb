// Scans for tests of the archive.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <system_error>
#include <vector>

#include "core/codec/payload_builder.h"
#include "core/io/file_io.h"
#include "core/scan_upload.h"
#include "storage/archive/scan_reader.h"
#include "storage/archive/scan_segment.h"

namespace isthmus::storage {

// For tests in which no power fails: the disk takes its time.
inline io::DiskCalls WithSync(int (*sync)(int)) {
  io::DiskCalls calls = io::DiskCalls::System();
  calls.sync = calls.sync_folder = sync;
  return calls;
}
inline int DoNotSync(int) { return 0; }

// A raw scan of rings and times; different for each sequence.
inline ScanUpload MakeUpload(uint64_t sequence, size_t points = 40) {
  std::mt19937 random(static_cast<uint32_t>(sequence));
  std::normal_distribution<float> coordinate(0, 10);
  std::vector<ScanPoint> cloud(points);
  for (size_t i = 0; i < points; ++i) {
    cloud[i] = {coordinate(random),
                coordinate(random),
                coordinate(random),
                static_cast<float>(i % 7),
                -0.1F + 0.0001F * static_cast<float>(i),
                static_cast<uint16_t>(i % 16)};
  }
  return {sequence, static_cast<int64_t>(1'000'000'000 * sequence),
          codec::MakePayload(cloud, true, true)};
}

inline void ExpectSame(const ScanUpload& a, const ScanUpload& b) {
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.end_stamp_ns, b.end_stamp_ns);
  EXPECT_EQ(a.payload.encoding, b.payload.encoding);
  EXPECT_EQ(a.payload.width, b.payload.width);
  EXPECT_EQ(a.payload.height, b.payload.height);
  EXPECT_EQ(a.payload.stride, b.payload.stride);
  EXPECT_EQ(a.payload.resolution_m, b.payload.resolution_m);
  ASSERT_EQ(a.payload.fields.size(), b.payload.fields.size());
  for (size_t i = 0; i < a.payload.fields.size(); ++i) {
    EXPECT_EQ(a.payload.fields[i].name, b.payload.fields[i].name);
    EXPECT_EQ(a.payload.fields[i].offset, b.payload.fields[i].offset);
    EXPECT_EQ(a.payload.fields[i].type, b.payload.fields[i].type);
    EXPECT_EQ(a.payload.fields[i].count, b.payload.fields[i].count);
  }
  EXPECT_TRUE(a.payload.data == b.payload.data);
}

struct ReadBack {
  std::vector<uint64_t> sequences;
  int64_t damaged = 0;
  uint64_t unfinished_bytes = 0;
};

// All scans of a session, each of which has to be as MakeUpload made it.
inline ReadBack ReadScans(const std::string& directory, const SessionId& session) {
  ReadBack back;
  const auto reader = ScanReader::Open(directory, session);
  if (absl::IsNotFound(reader.status())) return back;
  EXPECT_TRUE(reader.ok()) << reader.status();
  if (!reader.ok()) return back;
  while (true) {
    const auto scan = (*reader)->Next();
    EXPECT_TRUE(scan.ok()) << scan.status();
    if (!scan.ok() || !*scan) break;
    ExpectSame(**scan, MakeUpload((*scan)->sequence));
    back.sequences.push_back((*scan)->sequence);
  }
  back.damaged = (*reader)->damaged_count();
  back.unfinished_bytes = (*reader)->unfinished_bytes();
  return back;
}

// The sessions that have scans in `directory`/scans, in order.
inline std::vector<SessionId> ListArchivedSessions(const std::string& directory) {
  std::vector<SessionId> sessions;
  std::error_code error;
  for (std::filesystem::directory_iterator it(directory + "/scans", error), end;
       !error && it != end; it.increment(error)) {
    if (!ListSegments(it->path().string()).empty()) {
      sessions.emplace_back(it->path().filename().string());
    }
  }
  std::sort(sessions.begin(), sessions.end());
  return sessions;
}

inline std::vector<uint64_t> Range(uint64_t first, uint64_t last) {
  std::vector<uint64_t> range;
  for (uint64_t i = first; i <= last; ++i) range.push_back(i);
  return range;
}

inline std::string Bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void WriteBytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

}  // namespace isthmus::storage
