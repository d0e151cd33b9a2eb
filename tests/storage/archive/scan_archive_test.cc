// An archive of scans as it is used: scans come out as they went in, in order and once.
#include "storage/archive/scan_archive.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <atomic>
#include <cerrno>
#include <thread>

#include "core/codec/quantized.h"
#include "storage/archive/scan_record.h"
#include "storage/archive/scan_segment.h"
#include "tests/storage/scans.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {
namespace {

const SessionId kAlice("alice-1"), kBob("bob-1");

std::unique_ptr<ScanArchive> OpenArchive(const std::string& directory,
                                         uint64_t segment_bytes = 4096) {
  ScanArchiveOptions options;
  options.segment_bytes = segment_bytes;
  options.disk = WithSync(DoNotSync);
  return std::move(ScanArchive::Open(directory, options).value());
}

void Append(ScanArchive& archive, uint64_t first, uint64_t last,
            const SessionId& session = kAlice) {
  for (uint64_t i = first; i <= last; ++i) {
    ASSERT_TRUE(archive.Append(session, MakeUpload(i)).ok());
  }
}

int Segments(const TemporaryFolder& folder, const SessionId& session = kAlice) {
  return static_cast<int>(ListSegments(folder.path() + "/scans/" + session.value()).size());
}

ScanUpload RoundTrip(const ScanUpload& scan) {
  const io::Record record{.sequence = scan.sequence, .stamp_ns = scan.end_stamp_ns};
  return DecodeScan(record, EncodeScan(scan).value()).value();
}

TEST(ScanRecordTest, KeepsEveryBitOfAPayload) {
  const ScanUpload plain = MakeUpload(7, 1000);
  ExpectSame(RoundTrip(plain), plain);

  ScanUpload quantized = plain;
  quantized.payload = codec::Quantize(plain.payload, 0.002).value();
  ExpectSame(RoundTrip(quantized), quantized);

  ScanUpload padded = plain;  // Bytes that belong to no field, and fields that overlap.
  padded.payload.fields.erase(padded.payload.fields.begin() + 1);
  padded.payload.fields.push_back({"again", 2, ScalarType::kFloat64, 1});
  padded.payload.fields.push_back({"pair", 8, ScalarType::kUint16, 2});
  ExpectSame(RoundTrip(padded), padded);

  ScanUpload organised = plain;
  organised.payload.height = 10;
  organised.payload.width = 100;
  ExpectSame(RoundTrip(organised), organised);
}

TEST(ScanRecordTest, KeepsWhatNoDecoderTakes) {
  ScanUpload damaged = MakeUpload(1);
  damaged.payload.data.resize(damaged.payload.data.size() - 3);
  ExpectSame(RoundTrip(damaged), damaged);
  ScanUpload strange = MakeUpload(2);
  strange.payload.stride = 4'000'000'000;
  strange.payload.fields[0].type = static_cast<ScalarType>(99);
  strange.payload.fields[1].name = std::string("a\0b", 3);
  ExpectSame(RoundTrip(strange), strange);
  ExpectSame(RoundTrip({3, -5, {}}), {3, -5, {}});
}

TEST(ScanRecordTest, PacksRawScansWithoutLoss) {
  const ScanUpload scan = MakeUpload(1, 20'000);
  const size_t size = EncodeScan(scan)->size();
  EXPECT_LT(size, scan.payload.data.size() * 7 / 10);
}

TEST(ScanArchiveTest, ScansComeBackInOrderFromManySegments) {
  TemporaryFolder folder;
  const auto archive = OpenArchive(folder.path());
  Append(*archive, 1, 30);
  ASSERT_TRUE(archive->Sync(kAlice).ok());
  EXPECT_GT(Segments(folder), 3);
  const ReadBack back = ReadScans(folder.path(), kAlice);
  EXPECT_EQ(back.sequences, Range(1, 30));
  EXPECT_EQ(back.damaged, 0);
  EXPECT_EQ(back.unfinished_bytes, 0u);
  EXPECT_EQ(ListArchivedSessions(folder.path()), std::vector<SessionId>{kAlice});
  for (const int number : ListSegments(folder.path() + "/scans/alice-1")) {
    EXPECT_LE(std::filesystem::file_size(folder.path() + "/scans/alice-1/" + SegmentName(number)),
              4096u);
  }
}

TEST(ScanArchiveTest, AScanLargerThanASegmentHasOneToItself) {
  TemporaryFolder folder;
  const auto archive = OpenArchive(folder.path(), 100);
  Append(*archive, 1, 4);
  EXPECT_EQ(Segments(folder), 4);
  EXPECT_EQ(ReadScans(folder.path(), kAlice).sequences, Range(1, 4));
}

TEST(ScanArchiveTest, GoesOnWhereItWasAfterEveryStart) {
  TemporaryFolder folder;
  for (uint64_t i = 1; i <= 10; ++i) Append(*OpenArchive(folder.path(), 1 << 20), i, i);
  EXPECT_EQ(Segments(folder), 1);
  EXPECT_EQ(ReadScans(folder.path(), kAlice).sequences, Range(1, 10));
}

TEST(ScanArchiveTest, ScansThatCameTwiceAreTakenOnce) {
  TemporaryFolder folder;
  Append(*OpenArchive(folder.path()), 1, 20);
  const auto archive = OpenArchive(folder.path());
  Append(*archive, 8, 25);  // The robot sends again what was not durable.
  const ReadBack back = ReadScans(folder.path(), kAlice);
  EXPECT_EQ(back.sequences, Range(1, 25));
  EXPECT_EQ(back.damaged, 0);
}

TEST(ScanArchiveTest, FinishedSessionsTakeScansAllTheSame) {
  TemporaryFolder folder;
  const auto archive = ScanArchive::Open(folder.path()).value();
  Append(*archive, 1, 3);
  ASSERT_TRUE(archive->Finish(kAlice).ok());
  Append(*archive, 4, 6);
  EXPECT_EQ(ReadScans(folder.path(), kAlice).sequences, Range(1, 6));
}

TEST(ScanArchiveTest, CountsItsBytes) {
  TemporaryFolder folder;
  const auto on_disk = [&](const SessionId& session) {
    uint64_t bytes = 0;
    const std::string path = folder.path() + "/scans/" + session.value();
    for (const int number : ListSegments(path)) {
      bytes += std::filesystem::file_size(path + "/" + SegmentName(number));
    }
    return bytes;
  };
  auto archive = OpenArchive(folder.path());
  EXPECT_EQ(archive->Bytes(kAlice), 0u);
  Append(*archive, 1, 20);
  Append(*archive, 1, 3, kBob);
  EXPECT_EQ(archive->Bytes(kAlice), on_disk(kAlice));
  EXPECT_EQ(archive->Bytes(kBob), on_disk(kBob));
  archive = OpenArchive(folder.path());
  EXPECT_EQ(archive->Bytes(kAlice), on_disk(kAlice));
  EXPECT_EQ(archive->Bytes(kBob), on_disk(kBob));
  Append(*archive, 21, 30);
  EXPECT_EQ(archive->Bytes(kAlice), on_disk(kAlice));
}

TEST(ScanArchiveTest, RemovesASessionAndLeavesTheOthers) {
  TemporaryFolder folder;
  const auto archive = OpenArchive(folder.path());
  Append(*archive, 1, 20);
  Append(*archive, 1, 3, kBob);
  ASSERT_TRUE(archive->Remove(kAlice).ok());
  EXPECT_TRUE(archive->Remove(SessionId("never-1")).ok());
  EXPECT_EQ(archive->Bytes(kAlice), 0u);
  EXPECT_EQ(ListArchivedSessions(folder.path()), std::vector<SessionId>{kBob});
  EXPECT_TRUE(absl::IsNotFound(ScanReader::Open(folder.path(), kAlice).status()));
  Append(*archive, 5, 6);  // And it may begin anew.
  EXPECT_EQ(ReadScans(folder.path(), kAlice).sequences, Range(5, 6));
}

TEST(ScanArchiveTest, RemovesTheOldestScansFirst) {
  TemporaryFolder folder;
  const auto archive = OpenArchive(folder.path());
  Append(*archive, 1, 30);
  ASSERT_TRUE(archive->Finish(kAlice).ok());
  const uint64_t before = archive->Bytes(kAlice);
  const uint64_t freed = archive->RemoveOldestSegment(kAlice).value();
  EXPECT_GT(freed, 1000u);
  EXPECT_EQ(archive->Bytes(kAlice), before - freed);
  const ReadBack back = ReadScans(folder.path(), kAlice);
  ASSERT_FALSE(back.sequences.empty());
  EXPECT_GT(back.sequences.front(), 1u);
  EXPECT_EQ(back.sequences, Range(back.sequences.front(), 30));
  while (archive->RemoveOldestSegment(kAlice).value() > 0) {
  }
  EXPECT_EQ(archive->Bytes(kAlice), 0u);
  EXPECT_TRUE(ReadScans(folder.path(), kAlice).sequences.empty());
}

TEST(ScanArchiveTest, NamesThatAreNoFoldersAreRefused) {
  TemporaryFolder folder;
  const auto archive = OpenArchive(folder.path());
  for (const char* name : {"", ".", "..", "a/b", "../x"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(archive->Append(SessionId(name), MakeUpload(1)))) << name;
    EXPECT_TRUE(absl::IsInvalidArgument(archive->Remove(SessionId(name)))) << name;
  }
}

TEST(ScanArchiveTest, ManySessionsAtOnce) {
  TemporaryFolder folder;
  const auto archive = OpenArchive(folder.path());
  std::vector<std::thread> robots;
  for (int robot = 0; robot < 4; ++robot) {
    robots.emplace_back([&, robot] {
      const SessionId session("robot" + std::to_string(robot) + "-1");
      for (uint64_t i = 1; i <= 50; ++i) {
        EXPECT_TRUE(archive->Append(session, MakeUpload(i)).ok());
        if (i % 10 == 0) {
          EXPECT_TRUE(archive->Sync(session).ok());
          EXPECT_GT(archive->Bytes(session), 0u);
        }
      }
    });
  }
  for (std::thread& robot : robots) robot.join();
  for (int robot = 0; robot < 4; ++robot) {
    const SessionId session("robot" + std::to_string(robot) + "-1");
    EXPECT_EQ(ReadScans(folder.path(), session).sequences, Range(1, 50));
  }
}

// While it lives files cannot grow beyond a size: a disk that is full in the middle of a write.
class FullDiskAt {
 public:
  explicit FullDiskAt(uint64_t bytes) {
    handler_ = signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDiskAt() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_;
  void (*handler_)(int);
};

TEST(ScanArchiveTest, NothingIsHalfWrittenOnAFullDisk) {
  for (const uint64_t space : {1, 15, 16, 17, 500, 1500, 2000}) {
    TemporaryFolder folder;
    const auto archive = OpenArchive(folder.path(), 1 << 20);
    uint64_t kept = 0;
    {
      const FullDiskAt full(space);
      absl::Status status;
      while ((status = archive->Append(kAlice, MakeUpload(kept + 1))).ok()) ++kept;
      EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
      EXPECT_TRUE(absl::IsResourceExhausted(archive->Append(kAlice, MakeUpload(kept + 1))));
      EXPECT_EQ(ReadScans(folder.path(), kAlice).sequences, Range(1, kept)) << space;
    }
    Append(*archive, kept + 1, kept + 5);  // There is space again.
    EXPECT_TRUE(archive->Sync(kAlice).ok());
    const ReadBack back = ReadScans(folder.path(), kAlice);
    EXPECT_EQ(back.sequences, Range(1, kept + 5)) << space;
    EXPECT_EQ(back.damaged, 0);
  }
}

std::atomic<int> syncs_to_fail = 0;

int FailingSync(int descriptor) {
  if (syncs_to_fail > 0) {
    --syncs_to_fail;
    errno = ENOSPC;
    return -1;
  }
  return DoNotSync(descriptor);
}

// Scans of a failed sync are not trusted to the next one.
TEST(ScanArchiveTest, ScansThatCouldNotBeSyncedAreWrittenAnew) {
  TemporaryFolder folder;
  ScanArchiveOptions options;
  options.disk = WithSync(FailingSync);
  const auto archive = ScanArchive::Open(folder.path(), options).value();
  Append(*archive, 1, 3);
  ASSERT_TRUE(archive->Sync(kAlice).ok());
  Append(*archive, 4, 6);
  syncs_to_fail = 2;  // The file's, then that of the file written anew.
  EXPECT_TRUE(absl::IsResourceExhausted(archive->Sync(kAlice)));
  EXPECT_TRUE(absl::IsResourceExhausted(archive->Sync(kAlice)));
  EXPECT_TRUE(archive->Sync(kAlice).ok());
  EXPECT_EQ(Segments(folder), 2);
  Append(*archive, 7, 8);
  const ReadBack back = ReadScans(folder.path(), kAlice);
  EXPECT_EQ(back.sequences, Range(1, 8));
  EXPECT_EQ(back.damaged, 0);
  EXPECT_EQ(archive->Bytes(kAlice), OpenArchive(folder.path())->Bytes(kAlice));
}

TEST(ScanArchiveTest, SaysSoWhenTheDiskLostScansItHadTaken) {
  TemporaryFolder folder;
  ScanArchiveOptions options;
  options.disk = WithSync(FailingSync);
  auto archive = ScanArchive::Open(folder.path(), options).value();
  Append(*archive, 1, 3);
  ASSERT_TRUE(archive->Sync(kAlice).ok());
  const std::string segment = folder.path() + "/scans/alice-1/000001.scans";
  const size_t synced = Bytes(segment).size();
  Append(*archive, 4, 6);
  syncs_to_fail = 1;
  EXPECT_TRUE(absl::IsResourceExhausted(archive->Sync(kAlice)));
  std::string bytes = Bytes(segment);
  bytes[synced + 100] ^= 1;
  WriteBytes(segment, bytes);
  EXPECT_TRUE(absl::IsDataLoss(archive->Sync(kAlice)));
  EXPECT_TRUE(absl::IsDataLoss(archive->Sync(kAlice)));
  archive = ScanArchive::Open(folder.path(), options).value();
  Append(*archive, 4, 6);
  EXPECT_TRUE(archive->Sync(kAlice).ok());
  EXPECT_EQ(ReadScans(folder.path(), kAlice).sequences, Range(1, 6));
}

}  // namespace
}  // namespace isthmus::storage
