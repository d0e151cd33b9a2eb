// The judged numbers of the store in PostgreSQL.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace isthmus::storage {

// Statements sent before their answers are read. An answer is some 60 bytes, and unread ones have
// to fit into the socket's buffer (200 KB by Linux's default): were they more, both ends would wait
// for each other for ever.
inline constexpr size_t kSentAtOnce = 256;

// Connections that read: a query, an export, and two matchers. More would take the server's memory
// (about 10 MB each) and would wait for its disk.
inline constexpr int kPostgresReaders = 4;

// A connection that gives no sign for so long is lost. Shorter would cut links that stall for a
// moment; while it lasts nothing can be stored, and nobody else can take a dead machine's site.
inline constexpr std::chrono::seconds kSilence{15};

// Time that it may take to make a connection. A local one takes milliseconds.
inline constexpr std::chrono::seconds kConnecting{10};

// Between attempts to connect anew: doubled from one to the other. The server itself tries to store
// once a second; a longer last pause would be a longer wait after PostgreSQL is back.
inline constexpr std::chrono::milliseconds kFirstPause{100};
inline constexpr std::chrono::milliseconds kLastPause{2000};

// Time for which an owner without a sign of life keeps its site, unless the settings say otherwise.
// Shorter would take sites from servers whose machine or database is busy for a moment; longer is a
// longer wait for robots whose server hangs or is cut off.
inline constexpr std::chrono::milliseconds kLease{10'000};

// Renewals in the time of a lease: so many less one may fail in a row.
inline constexpr int kRenewals = 5;

// Between two renewals at most, however long the lease: they notice that the connection with the
// lock is gone, and make another.
inline constexpr std::chrono::milliseconds kRenewEvery{2000};

// Between two looks of a server that waits for a site, each a question of less than a millisecond.
// Robots wait so much longer than necessary after their server died.
inline constexpr std::chrono::milliseconds kLook{250};

// Time for which a server that waits for a site, and has lost its own connection, leaves it to its
// owner: the same trouble of PostgreSQL may have cut the owner's too. Longer than kRenewEvery and
// kLastPause, after which that is back; shorter, and a restart of PostgreSQL would take sites from
// servers that are well.
inline constexpr std::chrono::milliseconds kGiveWay{3000};

// Time to wait for a site's lock before telling who holds it. A killed server's goes as soon as
// PostgreSQL sees that its socket is closed, at the latest after the statement under way.
inline constexpr std::chrono::seconds kWaitForLock{5};

// Rows about servers that had a site open, for people who ask later who wrote when.
inline constexpr int kOwnersKept = 100;

// Entries of trajectories that a reader takes at a time, some 20 MB: the rest follows at the next
// look. They tell how far robots went and where they are, and nothing waits for them.
inline constexpr int64_t kEntriesAtOnce = 100'000;

// Between two looks at how large the tables are. The question takes milliseconds.
inline constexpr std::chrono::seconds kSizeIsGoodFor{60};

// Time for which a job is its worker's after the last sign of life, time between two signs, and
// time for which a silent worker counts as there. Shorter would give jobs of a worker that is busy
// for a moment to another one; longer is a longer wait for the jobs of one that died.
inline constexpr std::chrono::milliseconds kJobLease{15'000}, kWorkerSign{3000},
    kWorkerIsGone{10'000};

// Times that a job is taken by workers that end without a word, before it is set aside. Workers are
// ended by others as well: more than the server's own ends at a task (kMaxCrashes).
inline constexpr int kMaxAttempts = 5;
// Such times after which a server without workers does it itself: as kMaxCrashes.
inline constexpr int kMaxWithdrawnAttempts = 2;

}  // namespace isthmus::storage
