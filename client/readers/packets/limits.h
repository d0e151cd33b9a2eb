// The limits of what sensors and captures may ask for, and what is judged of their clocks.
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::readers {

// Nanoseconds. A sensor's clock within this of the clock of arrival is taken to be synchronised.
// Networks and disks delay packets by milliseconds; clocks that nobody synchronised are off by
// anything. Smaller: a host a little off would throw away good sensor times. Larger: a free clock
// that happens to be near is believed.
inline constexpr int64_t kClockAgreementNs = 3'000'000'000;

// Nanoseconds. The delay of arrival is the least one of the last one or two of these. Free clocks
// drift by up to 50 ppm, 0.5 ms in 10 s; shorter windows may see delayed packets alone.
inline constexpr int64_t kDelayWindowNs = 10'000'000'000;

// Nanoseconds. A free clock that jumps by more against that of arrival was set anew.
inline constexpr int64_t kClockJumpNs = 1'000'000'000;

// Nanoseconds. A longer pause between packets may miss a turn, which is then told by the speed: two
// turns of the fastest sensor (20 Hz). Parts of different turns must not become one scan.
inline constexpr int64_t kPacketGapNs = 100'000'000;

// Nanoseconds. A scan is cut after so much where the azimuth never passes the cut; the slowest
// sensors take 200 ms for a turn.
inline constexpr int64_t kLongestTurnNs = 500'000'000;

// Points. Likewise where the clock stands still: twice what an HDL-64E gives in 200 ms.
inline constexpr size_t kMaxTurnPoints = 1'000'000;

// Hundredths of a degree between blocks that follow each other; 20 Hz give 80. More is a gap of the
// field of view, over which the speed must not be taken; backwards, it is the encoder's trembling.
inline constexpr int kMaxAzimuthStep = 200;

// Columns and rows of an Ouster scan: twice the largest there are, so that a metadata file that
// lies does not cost memory.
inline constexpr int kMaxOusterColumns = 4096;
inline constexpr int kMaxOusterRows = 256;

// Nanoseconds from firing to firing of a Livox; a Mid-40 takes 10 us. More between two packets is
// one that was lost.
inline constexpr int64_t kLongestIntervalNs = 15'000;

// Datagrams that are being put together from fragments, of 64 KiB at most each. A sensor sends
// fragments one after the other, so one is enough for each of a few sensors.
inline constexpr size_t kMaxOpenDatagrams = 16;

// Nanoseconds. Fragments that are older belong to a datagram that was lost: their numbers start
// again after 65536 datagrams, 50 s of the fastest sensor.
inline constexpr int64_t kFragmentAgeNs = 5'000'000'000;

// Sensors in a capture, and receivers of GNSS; more are left out, and noted.
inline constexpr size_t kMaxCaptureTopics = 64;

// Fixes of a capture: a day at 10 Hz.
inline constexpr size_t kMaxFixes = 1'000'000;

// Bytes of a metadata or calibration file; real ones have 10 to 50 KB.
inline constexpr size_t kMaxDescriptionBytes = 4u << 20;

// Nanoseconds. A GPRMC sentence is that of the last full second, and comes within two.
inline constexpr int64_t kSentenceDelayNs = 2'500'000'000;

// Bytes. Half a second of the fastest sensor (34 MB/s), with the kernel's share.
inline constexpr int kReceiveBufferBytes = 32 << 20;

// Packets that are looked at before a live sensor counts as unknown: a second of another program's.
inline constexpr size_t kMaxForeignPackets = 1000;

}  // namespace isthmus::readers
