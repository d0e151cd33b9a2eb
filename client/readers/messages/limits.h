// Limits of what a recording of messages may claim, and of what is looked through for its sake.
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::readers {

// Bytes of a chunk once unpacked. Recorders make them of 0.75 (rosbag) to 4 MB (mcap), and larger
// where one message is; a message of codec::kMaxDecodedBytes still fits. More lets a file of a few
// bytes take all memory.
inline constexpr uint64_t kMaxChunkBytes = 512u << 20;
// Bytes of chunks, once unpacked, that are held beside the one that is read, where the times of
// several overlap: some dozen of a recorder's. More takes memory, less has chunks read again where
// many overlap.
inline constexpr uint64_t kMaxOpenBytes = 128u << 20;
// Bytes that are made room for when unpacking begins, as a multiple of the packed ones; the room
// then grows as it is filled. Text and empty images pack better than that, clouds do not.
inline constexpr uint64_t kFirstRoomRatio = 16;
// Bytes of the header of a bag's record: those that exist have less than 200, but for connections,
// whose topic may be long.
inline constexpr uint32_t kMaxBagHeaderBytes = 64u << 10;
// Bytes of a record that is not a chunk, where its length is all that tells whether it is damaged:
// a definition of messages, a metadata text.
inline constexpr uint64_t kMaxSmallRecordBytes = 64u << 20;
// Bytes of messages outside of chunks that are read at once. Less takes more system calls.
inline constexpr uint64_t kLooseBlockBytes = 1u << 20;
// Bytes that are read at once where only the heads of records are wanted.
inline constexpr size_t kWindowBytes = 64u << 10;
// Bytes that are looked through at once for the next undamaged chunk.
inline constexpr size_t kSearchBytes = 1u << 20;
// Bytes before its "op" field within which a bag's chunk header begins: two more fields, the
// longest being the name of the compression.
inline constexpr size_t kChunkHeadBytes = 96;

// Seconds by which times of recording go back, once, where a clock was set: messages that are
// written late are so by less, as recorders write what they hold several times a second. A guess.
inline constexpr double kLeastStepBackS = 1;
// Seconds between two parts of a recording that were joined in the wrong order, one going on where
// the other ends; more, and a clock was set. A guess.
inline constexpr double kMostJoinedS = 10;
// Messages of a database below which they are counted when it is opened and no metadata.yaml says
// their number: a second or two on a slow disk.
inline constexpr int64_t kMaxCountedMessages = 1'000'000;
// Bytes of a metadata.yaml, a sensor's JSON or a calibration: those that exist have less than 1 MB.
inline constexpr uint64_t kMaxTextBytes = 16u << 20;

// Bytes of a string in a message: names of frames and fields, and Ouster's JSON, have fewer.
inline constexpr uint32_t kMaxStringBytes = 16u << 20;
// Packets of a VelodyneScan from which on it is taken for a turn. A turn of the smallest sensor at
// its fastest, 20 Hz, has 38; drivers that send packets one by one have 1.
inline constexpr size_t kMinTurnPackets = 16;
// Damaged places named in the notes; the others are counted.
inline constexpr size_t kMaxNotedDamages = 5;

}  // namespace isthmus::readers
