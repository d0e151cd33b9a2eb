// The fast loop: composes the merged map anew, with the transforms at hand, on a thread of its own.
#pragma once

#include <thread>

#include "server/composition/composer.h"
#include "server/pipeline/map_state.h"

namespace isthmus::server {

class Compositor {
 public:
  // Composes after changes, at most once per interval (0: at once).
  Compositor(MapState* state, SubmapReader reader, const composition::ComposerOptions& options,
             double interval_s);
  ~Compositor();

  // Makes the thread end after one last composition of what is there; does not wait.
  void Stop();

 private:
  void Run();

  MapState* const state_;
  const SubmapReader reader_;
  const double interval_s_;
  composition::Composer composer_;  // Touched by the thread only.
  bool stop_ = false;               // Guarded by the state's mutex.
  std::thread thread_;
};

}  // namespace isthmus::server
