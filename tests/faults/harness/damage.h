// A map folder whose disk went bad, and the server's answer to it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/faults/harness/fleet.h"

namespace isthmus::faults {

enum class Damage {
  kSubmapBits,  // Flipped in the blob of one submap.
  kPageBits,    // Flipped in any pages of the database.
  kTornPage,    // Some sectors of a page are of another time: zeros.
  kLogBits,     // Flipped in the write-ahead log.
  kTornLog,     // The log ends in the middle.
  kMissingLog,
  kTruncated,      // The database ends in the middle.
  kEmptyDatabase,  // No byte of it is left.
  kNoise,          // All of it is.
};
const std::vector<Damage>& AllDamages();
std::string ToString(Damage damage);

// A map folder as it is after a server with two robots was killed: database and log. Returns its
// path.
std::string MakeDamageMaster(const Setup& setup);

struct DamageTrial {
  Damage damage = Damage::kSubmapBits;
  uint64_t seed = 1;
  bool is_up = false;               // The server started; else it refused with a message.
  bool is_reported = false;         // By the server's log or by --check.
  uint64_t submaps = 0;             // Listed; there were `submaps_whole` before the damage.
  uint64_t points = 0;              // Points of the whole map, as queried.
  std::string words;                // The first warning or error of the log.
  std::vector<std::string> broken;  // Crashes, hangs, silence.
};

// Damages a copy of `master`, starts a server on it, asks it everything, streams new scans, stops
// it, and has it checked.
DamageTrial TryDamage(const Setup& setup, const std::string& master, Damage damage, uint64_t seed);

// Each damage with so many seeds, as one report.
Report DamageFolders(const Setup& setup, int seeds);

}  // namespace isthmus::faults
