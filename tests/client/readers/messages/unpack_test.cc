#include "client/readers/messages/unpack.h"

#include <bzlib.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <zstd.h>

#include "client/readers/messages/limits.h"

namespace isthmus::readers {
namespace {

// Incompressible enough to take several blocks of every compression.
std::string Content(size_t size) {
  std::string content(size, '\0');
  uint32_t state = 1;
  for (char& c : content) {
    state = state * 1664525 + 1013904223;
    c = static_cast<char>(state >> 28);
  }
  return content;
}

std::string Pack(Compression compression, std::string content) {
  std::string packed(2 * content.size() + 1000, '\0');
  size_t size = packed.size();
  if (compression == Compression::kNone) return content;
  if (compression == Compression::kBz2) {
    auto room = static_cast<unsigned>(size);
    EXPECT_EQ(BZ2_bzBuffToBuffCompress(packed.data(), &room, content.data(),
                                       static_cast<unsigned>(content.size()), 1, 0, 0),
              BZ_OK);
    size = room;
  } else if (compression == Compression::kLz4) {
    size = LZ4F_compressFrame(packed.data(), size, content.data(), content.size(), nullptr);
  } else {
    size = ZSTD_compress(packed.data(), size, content.data(), content.size(), 3);
  }
  packed.resize(size);
  return packed;
}

class UnpackTest : public testing::TestWithParam<Compression> {
 protected:
  absl::Status Run(const std::string& packed, uint64_t claimed) {
    return Unpack(GetParam(), packed, claimed, &content_);
  }
  std::string content_;
};

TEST_P(UnpackTest, GivesBackWhatWasPacked) {
  for (const size_t size : {0, 1, 1000, 500'000}) {
    const std::string content = Content(size);
    EXPECT_TRUE(Run(Pack(GetParam(), content), size).ok()) << size;
    EXPECT_EQ(content_, content);
  }
}

TEST_P(UnpackTest, WhatIsCutOffIsUnpackedUpToThere) {
  const std::string content = Content(500'000);
  const std::string packed = Pack(GetParam(), content);
  const absl::Status status = Run(packed.substr(0, packed.size() * 3 / 4), content.size());
  EXPECT_TRUE(absl::IsOutOfRange(status)) << status;
  EXPECT_GT(content_.size(), content.size() / 8);
  EXPECT_EQ(content_, content.substr(0, content_.size()));
}

TEST_P(UnpackTest, AnotherSizeThanWasClaimedIsRefused) {
  const std::string packed = Pack(GetParam(), Content(100'000));
  EXPECT_TRUE(absl::IsDataLoss(Run(packed, 99'999)));
  EXPECT_FALSE(Run(packed, 100'001).ok());
  EXPECT_FALSE(Run(packed, 0).ok());
  EXPECT_TRUE(absl::IsInvalidArgument(Run(packed, kMaxChunkBytes + 1)));
}

TEST_P(UnpackTest, ABombUnpacksToNoMoreThanItClaims) {
  if (GetParam() == Compression::kNone) return;
  const std::string bomb = Pack(GetParam(), std::string(8'000'000, '\0'));
  EXPECT_TRUE(absl::IsDataLoss(Run(bomb, 1000)));
  EXPECT_LE(content_.capacity(), 2'000'000u);
}

TEST(UnpackedMessageTest, AFrameIsUnpackedWhereNoMessageBeginsSo) {
  const std::string plain("\0\1\0\0 a message of CDR", 21);
  const std::string frame = Pack(Compression::kZstd, plain);
  std::string content;
  EXPECT_EQ(UnpackedMessage("cdr", frame, &content).value(), plain);
  EXPECT_EQ(UnpackedMessage("cdr", plain, &content).value(), plain);
  EXPECT_EQ(UnpackedMessage("ros1", frame, &content).value(), frame);
  EXPECT_TRUE(absl::IsDataLoss(
      UnpackedMessage("cdr", frame.substr(0, frame.size() - 4), &content).status()));
}

// As recorders write that compress while they go.
std::string PackWithoutSize(const std::string& content) {
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, 0);
  std::string packed(2 * content.size() + 1000, '\0');
  packed.resize(
      ZSTD_compress2(context, packed.data(), packed.size(), content.data(), content.size()));
  ZSTD_freeCCtx(context);
  return packed;
}

TEST(UnpackedMessageTest, FramesOfLz4AndThoseWithoutASizeAreUnpacked) {
  const std::string plain = std::string("\0\1\0\0", 4) + Content(300'000);
  std::string content;
  for (const std::string& frame : {Pack(Compression::kLz4, plain), PackWithoutSize(plain)}) {
    EXPECT_EQ(UnpackedMessage("cdr", frame, &content).value(), plain);
    for (const size_t kept : {frame.size() - 1, frame.size() / 2, size_t{5}}) {
      const auto cut = UnpackedMessage("cdr", frame.substr(0, kept), &content);
      EXPECT_TRUE(absl::IsDataLoss(cut.status())) << kept;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, UnpackTest,
                         testing::Values(Compression::kNone, Compression::kBz2, Compression::kLz4,
                                         Compression::kZstd));

}  // namespace
}  // namespace isthmus::readers
