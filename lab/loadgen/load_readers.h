// Readers beside the robots: each asks for the state of the map, the sessions and the points around
// a robot in turn.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "core/concurrency/mutex.h"

namespace isthmus::loadgen {

struct ReaderResult {
  std::vector<double> ms;             // Time to the answer, per call.
  std::map<std::string, int> errors;  // Message and count.
};

// Thread safe.
class LoadReaders {
 public:
  // So many readers, each of which asks once in `period_s`. 0: none.
  LoadReaders(const std::string& server, int readers, double period_s);
  ~LoadReaders();

  // By the name of the call.
  std::map<std::string, ReaderResult> Results() const;

 private:
  void Read(const std::string& server, double period_s, uint64_t seed);

  std::atomic<bool> stopping_ = false;
  mutable Mutex mutex_;
  std::map<std::string, ReaderResult> results_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::thread> threads_;
};

}  // namespace isthmus::loadgen
