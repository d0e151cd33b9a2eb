// The scans of a session on disk, through crashes, bad disks and full ones.
#include "client/library/spool/disk_spool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/library/spool/spool_folder.h"
#include "tests/client/library/spool_files.h"

namespace isthmus::client {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::string PayloadOf(uint64_t sequence) { return "payload of " + std::to_string(sequence); }

class DiskSpoolTest : public testing::Test {
 protected:
  std::unique_ptr<DiskSpool> Create() {
    SpoolIdentity identity;
    identity.request.set_robot("alice");
    identity.request.set_request_id("r1");
    auto spool = DiskSpool::Create(folder_, identity, options_);
    EXPECT_TRUE(spool.ok()) << spool.status();
    return *std::move(spool);
  }
  std::unique_ptr<DiskSpool> Open() {
    auto spool = DiskSpool::Open(folder_, options_);
    EXPECT_TRUE(spool.ok()) << spool.status();
    return *std::move(spool);
  }
  static void Append(DiskSpool& spool, int scans) {
    for (int i = 0; i < scans; ++i) {
      const uint64_t next = spool.written() + 1;
      const auto sequence = spool.Append(static_cast<int64_t>(100 * next), PayloadOf(next), 1.0);
      ASSERT_TRUE(sequence.ok()) << sequence.status();
      ASSERT_EQ(*sequence, next);
    }
  }
  static void ExpectWhole(const DiskSpool& spool, uint64_t from, uint64_t to) {
    for (uint64_t i = from; i <= to; ++i) {
      const auto payload = spool.Read(i);
      ASSERT_TRUE(payload.ok()) << payload.status();
      EXPECT_EQ(*payload, PayloadOf(i));
      EXPECT_EQ(spool.StampBefore(i + 1), static_cast<int64_t>(100 * i));
    }
  }

  SpoolFiles files_;
  const std::string folder_ = files_.path() + "/000001";
  DiskSpool::Options options_;
};

TEST_F(DiskSpoolTest, GoesOnWhereTheLastProgramStopped) {
  {
    const auto spool = Create();
    Append(*spool, 3);
    SpoolIdentity identity = spool->identity();
    identity.session = "alice-1";
    identity.base = 2;
    ASSERT_TRUE(spool->SetIdentity(identity).ok());
  }
  const auto spool = Open();
  EXPECT_EQ(spool->identity().session, "alice-1");
  EXPECT_EQ(spool->identity().request.robot(), "alice");
  EXPECT_EQ(spool->identity().base, 2u);
  EXPECT_FALSE(spool->identity().closed);
  EXPECT_EQ(spool->written(), 3u);
  EXPECT_EQ(spool->safe(), 3u);
  Append(*spool, 2);
  ExpectWhole(*spool, 1, 5);
  EXPECT_THAT(spool->TakeNotes(), IsEmpty());
}

// Programs before the odometry was an enumeration named it by a string, as field 4.
TEST_F(DiskSpoolTest, TheOdometryThatAnOlderProgramNamedIsKept) {
  SpoolIdentity identity;
  identity.request.set_robot("alice");
  const auto& fields = *identity.request.GetReflection();
  fields.MutableUnknownFields(&identity.request)->AddLengthDelimited(4, "floam");
  ASSERT_TRUE(DiskSpool::Create(folder_, identity, options_).ok());
  EXPECT_EQ(Open()->identity().request.odometry(), v1::ODOMETRY_FLOAM);
}

TEST_F(DiskSpoolTest, ATornTailIsCutOffWhereverItTears) {
  {
    const auto spool = Create();
    Append(*spool, 3);
  }
  const std::string path = files_.Segments().front();
  const std::string whole = ReadFile(path);
  const size_t record = io::kRecordHeaderBytes + PayloadOf(3).size();
  for (size_t torn = 1; torn < record; ++torn) {
    WriteFile(path, whole.substr(0, whole.size() - torn));
    const auto spool = Open();
    ASSERT_EQ(spool->written(), 2u) << torn;
    EXPECT_THAT(spool->TakeNotes(), SizeIs(1));
    Append(*spool, 1);  // Takes the place of the torn one.
    ExpectWhole(*spool, 1, 3);
    EXPECT_EQ(ReadFile(path), whole);
  }
}

TEST_F(DiskSpoolTest, ADamagedScanInTheMiddleIsToldAndTheOthersStay) {
  {
    const auto spool = Create();
    Append(*spool, 4);
  }
  const std::string path = files_.Segments().front();
  std::string bytes = ReadFile(path);
  bytes[bytes.find(PayloadOf(2))] ^= 1;
  WriteFile(path, bytes);
  const auto spool = Open();
  EXPECT_EQ(spool->written(), 4u);
  EXPECT_FALSE(spool->Read(2).ok());
  EXPECT_FALSE(spool->Find(2).has_value());
  EXPECT_EQ(spool->StampBefore(3), 100);
  ExpectWhole(*spool, 3, 4);
  const auto notes = spool->TakeNotes();
  ASSERT_THAT(notes, SizeIs(1));
  EXPECT_THAT(notes[0], HasSubstr("damaged"));
}

TEST_F(DiskSpoolTest, DamageInAnOlderFileIsSeenWhenTheScanIsRead) {
  options_.segment_bytes = 1;  // A file per scan.
  {
    const auto spool = Create();
    Append(*spool, 3);
  }
  std::string bytes = ReadFile(files_.Segments()[1]);
  bytes.back() ^= 1;
  WriteFile(files_.Segments()[1], bytes);
  const auto spool = Open();
  EXPECT_TRUE(absl::IsDataLoss(spool->Read(2).status())) << spool->Read(2).status();
  ExpectWhole(*spool, 3, 3);
}

TEST_F(DiskSpoolTest, FilesGoWhenAllInThemIsDurable) {
  options_.segment_bytes = 1;
  const auto spool = Create();
  Append(*spool, 5);
  ASSERT_THAT(files_.Segments(), SizeIs(5));
  const uint64_t bytes = spool->bytes();
  spool->Release(0, 5);
  EXPECT_THAT(files_.Segments(), SizeIs(5));
  spool->Release(3, 5);
  EXPECT_THAT(files_.Segments(), SizeIs(2));
  EXPECT_LT(spool->bytes(), bytes);
  EXPECT_EQ(spool->first(), 4u);
  EXPECT_TRUE(absl::IsNotFound(spool->Read(3).status()));
  spool->Release(100, 5);  // The newest stays, and with it the number of the next.
  EXPECT_THAT(files_.Segments(), SizeIs(1));
  const auto reopened = Open();
  EXPECT_EQ(reopened->written(), 5u);
  EXPECT_EQ(reopened->StampBefore(6), 500);
}

TEST_F(DiskSpoolTest, AFullDiskRefusesTheScanAndTakesItLater) {
  FailingDisk disk;
  options_.disk = &disk.calls();
  const auto spool = Create();
  Append(*spool, 1);
  disk.room = 20;
  const auto refused = spool->Append(200, PayloadOf(2), 1.0);
  EXPECT_TRUE(absl::IsResourceExhausted(refused.status())) << refused.status();
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("make room"));
  EXPECT_EQ(spool->written(), 1u);
  EXPECT_EQ(Open()->written(), 1u);
  disk.room.reset();
  Append(*spool, 2);
  ExpectWhole(*spool, 1, 3);
}

TEST_F(DiskSpoolTest, OnAFullDiskDurableScansGo) {
  for (const uint64_t room : {500, 530, 560, 590}) {  // With and without a file's head behind.
    SCOPED_TRACE(room);
    const SmallDisk disk(folder_, room);
    options_.disk = &disk.calls();
    const auto spool = Create();
    absl::Status full;
    while (full.ok()) full = spool->Append(100, PayloadOf(spool->written() + 1), 1.0).status();
    EXPECT_TRUE(absl::IsResourceExhausted(full)) << full;
    const uint64_t written = spool->written();
    spool->Release(written, written);
    while (spool->written() < written + 3) {
      (void)spool->Append(100, PayloadOf(spool->written() + 1), 1.0);
      spool->Release(written, written);
    }
    EXPECT_GT(spool->first(), 1u);
    EXPECT_EQ(Open()->written(), written + 3);
    ASSERT_TRUE(spool->Remove().ok());
  }
}

TEST_F(DiskSpoolTest, AnFsyncThatFailsTakesNothing) {
  FailingDisk disk;
  options_.disk = &disk.calls();
  const auto spool = Create();
  Append(*spool, 1);
  disk.fails_to_sync = true;
  EXPECT_TRUE(absl::IsUnavailable(spool->Append(200, PayloadOf(2), 1.0).status()));
  EXPECT_EQ(spool->written(), 1u);
  disk.fails_to_sync = false;
  Append(*spool, 2);  // Into another file: the first one's content is not certain any more.
  EXPECT_THAT(files_.Segments(), SizeIs(2));
  ExpectWhole(*Open(), 1, 3);
}

TEST_F(DiskSpoolTest, AnFsyncThatFailsBeforeTheFirstScanIsNoTrap) {
  FailingDisk disk;
  options_.disk = &disk.calls();
  const auto spool = Create();
  disk.fails_to_sync = true;
  EXPECT_FALSE(spool->Append(100, PayloadOf(1), 1.0).ok());
  EXPECT_FALSE(spool->Append(100, PayloadOf(1), 1.0).ok());
  disk.fails_to_sync = false;
  Append(*spool, 2);
  ExpectWhole(*spool, 1, 2);
  ExpectWhole(*Open(), 1, 2);
}

TEST_F(DiskSpoolTest, SyncsAsOftenAsAsked) {
  FailingDisk disk;
  options_.disk = &disk.calls();
  options_.sync_interval_s = 0.05;
  const auto spool = Create();
  const int before = disk.syncs;
  ASSERT_TRUE(spool->Append(1, "a", 10.00).ok());
  EXPECT_EQ(disk.syncs, before + 1);
  ASSERT_TRUE(spool->Append(2, "b", 10.04).ok());
  EXPECT_EQ(disk.syncs, before + 1);
  EXPECT_EQ(spool->safe(), 1u);
  EXPECT_EQ(spool->written(), 2u);
  ASSERT_TRUE(spool->Sync(10.045).ok());
  EXPECT_EQ(spool->safe(), 2u);
  ASSERT_TRUE(spool->Append(3, "c", 10.08).ok());
  EXPECT_EQ(spool->safe(), 2u);
  ASSERT_TRUE(spool->Append(4, "d", 10.10).ok());
  EXPECT_EQ(spool->safe(), 4u);
}

TEST_F(DiskSpoolTest, NumbersCanBeLeftOut) {
  {
    const auto spool = Create();
    Append(*spool, 2);
    EXPECT_TRUE(absl::IsAborted(spool->Skip(1, 9))) << "a scan came in between";
    ASSERT_TRUE(spool->Skip(2, 9).ok());
  }
  const auto spool = Open();
  EXPECT_EQ(spool->written(), 9u);
  Append(*spool, 1);
  EXPECT_FALSE(spool->Find(9).has_value());
  ExpectWhole(*spool, 10, 10);
}

TEST_F(DiskSpoolTest, OldestFilesCanBeGivenUp) {
  options_.segment_bytes = 1;
  const auto spool = Create();
  Append(*spool, 3);
  EXPECT_TRUE(spool->DropOldest());
  EXPECT_TRUE(spool->DropOldest());
  EXPECT_FALSE(spool->DropOldest()) << "the newest stays";
  EXPECT_EQ(spool->first(), 3u);
  ExpectWhole(*spool, 3, 3);
}

TEST_F(DiskSpoolTest, AProgramThatDiedWhileItBeganAFileIsNoTrap) {
  options_.segment_bytes = 1;
  {
    const auto spool = Create();
    Append(*spool, 2);
  }
  const std::string newest = folder_ + "/00000000000000000003.scans";
  for (const char* bytes : {"", "ISTHSPL1", "\0\0\0\0"}) {
    WriteFile(newest, bytes);
    const auto spool = Open();
    EXPECT_EQ(spool->written(), 2u);
  }
  const auto spool = Open();
  Append(*spool, 1);
  ExpectWhole(*Open(), 1, 3);
}

TEST_F(DiskSpoolTest, ADamagedIdentityIsToldAndNothingIsTouched) {
  {
    const auto spool = Create();
    Append(*spool, 2);
  }
  const std::string path = folder_ + "/session";
  const std::string whole = ReadFile(path);
  for (size_t at = 0; at < whole.size(); ++at) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 4);
    WriteFile(path, bytes);
    const auto spool = DiskSpool::Open(folder_, options_);
    EXPECT_TRUE(absl::IsDataLoss(spool.status())) << at << ": " << spool.status();
  }
  WriteFile(path, whole);
  ExpectWhole(*Open(), 1, 2);
}

TEST_F(DiskSpoolTest, FilesOfAnotherSessionAreRefusedAndNotTouched) {
  Append(*Create(), 2);
  const std::string path = files_.Segments().front(), whole = ReadFile(path);
  SpoolIdentity identity = Open()->identity();
  identity.request.set_request_id("r1.another");  // As after a change of the session.
  ASSERT_TRUE(WriteIdentity(folder_, identity).ok());
  ExpectWhole(*Open(), 1, 2);
  identity.request.set_request_id("r2");
  ASSERT_TRUE(WriteIdentity(folder_, identity).ok());
  const auto spool = DiskSpool::Open(folder_, options_);
  ASSERT_TRUE(absl::IsDataLoss(spool.status())) << spool.status();
  EXPECT_THAT(std::string(spool.status().message()), HasSubstr("of another spool"));
  EXPECT_EQ(ReadFile(path), whole);
}

TEST(SpoolFolderTest, IsForOneProgramAtATime) {
  const SpoolFiles files;
  auto folder = SpoolFolder::Open(files.path() + "/robot");
  ASSERT_TRUE(folder.ok()) << folder.status();
  const auto second = SpoolFolder::Open(files.path() + "/robot");
  ASSERT_TRUE(absl::IsFailedPrecondition(second.status())) << second.status();
  EXPECT_THAT(std::string(second.status().message()), HasSubstr("in use by process"));
  folder->reset();
  EXPECT_TRUE(SpoolFolder::Open(files.path() + "/robot").ok());
}

TEST(SpoolFolderTest, SessionsComeBackInOrderAndHalfMadeOnesAreCleared) {
  const SpoolFiles files;
  {
    auto folder = SpoolFolder::Open(files.path());
    for (const char* session : {"a-1", "a-2"}) {
      SpoolIdentity identity;
      identity.session = session;
      ASSERT_TRUE((*folder)->Add(identity, {}).ok());
    }
  }
  std::filesystem::create_directories(files.path() + "/000003");
  auto folder = SpoolFolder::Open(files.path());
  const auto spools = (*folder)->Load({});
  ASSERT_TRUE(spools.ok()) << spools.status();
  ASSERT_THAT(*spools, SizeIs(2));
  EXPECT_EQ((*spools)[0]->identity().session, "a-1");
  EXPECT_EQ((*spools)[1]->identity().session, "a-2");
  EXPECT_FALSE(std::filesystem::exists(files.path() + "/000003"));
}

TEST(SpoolFolderTest, ScansWithoutTheirSessionAreKeptAndToldOf) {
  const SpoolFiles files;
  ASSERT_TRUE((*SpoolFolder::Open(files.path()))->Add({}, {}).ok());
  const std::string session = files.path() + "/000001/session";
  std::filesystem::rename(session, files.path() + "/session");
  {
    const auto spools = (*SpoolFolder::Open(files.path()))->Load({});
    ASSERT_TRUE(absl::IsDataLoss(spools.status())) << spools.status();
    EXPECT_THAT(std::string(spools.status().message()), HasSubstr("session is missing"));
    EXPECT_THAT(files.Segments(), SizeIs(1));
  }
  // Unless the program died while it removed them.
  std::filesystem::rename(files.path() + "/session", session);
  ASSERT_TRUE(RetireIdentity(files.path() + "/000001").ok());
  EXPECT_THAT(*(*SpoolFolder::Open(files.path()))->Load({}), IsEmpty());
  EXPECT_THAT(files.Segments(), IsEmpty());
}

}  // namespace
}  // namespace isthmus::client
