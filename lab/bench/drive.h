// A drive as the odometry is given it: which scans, in which order, with which stamps.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/pose.h"
#include "core/scan.h"

namespace isthmus::bench {

enum class View {
  kWhole,
  kHalf,   // Nothing ahead: what a hand or a wall of cardboard leaves.
  kBlank,  // Nothing at all.
};

// One scan that is handed over.
struct Shot {
  int turn = 0;              // The sensor's turn, counted from 0: gives the scan and its true pose.
  int64_t end_stamp_ns = 0;  // The stamp that the robot gives, which may not be true.
  View view = View::kWhole;
};

using Shots = std::vector<Shot>;

// Functions are deterministic; the same turn may be asked for again.
struct Drive {
  std::string sensor;  // Name of a sensor model.
  Shots shots;
  std::function<Scan(int turn)> scan_of;   // With the turn's own stamp.
  std::function<Pose(int turn)> truth_of;  // T_world_sensor at the END of the turn.
  std::function<void()> record;  // To call once before scan_of, if there is one: what takes long.

  // A pose farther than this from the truth is wrong.
  double wrong_m = 0.2;
  int trouble_ends = -1;  // First shot after the last that something was done to; -1: nothing was.
  int lap_begins = 0;     // From this shot on ...
  int lap_shots = 0;      // ... every so many are a lap; 0: there are no laps.
};

// The scan of a shot, with the shot's stamp and as much of the view as it has.
Scan MakeScan(const Drive& drive, const Shot& shot, uint64_t sequence);

// Scans one after the other, as a sensor that nothing happens to sends them.
Shots InOrder(int turns, double period_s);

// Mishaps of robots. Each changes shots from `at` on.
void Cover(Shots* shots, int at, int count, View view);
void Drop(Shots* shots, int at, int count);
void KeepEvery(Shots* shots, int nth);  // Key scans: the first and every nth after it.
void Duplicate(Shots* shots, int at);   // Sends the shot again.
void Swap(Shots* shots, int at);        // Sends it after the one that follows.
void StepClock(Shots* shots, int at, double by_s);
void PutElsewhere(Shots* shots, int at,
                  int by_turns);  // From there, as if this much later or earlier.

}  // namespace isthmus::bench
