// The lock of FFTW's planner, the one part of it that threads must not share.
#pragma once

#include "core/concurrency/mutex.h"

namespace isthmus::matching {

// Held while a plan is made or destroyed.
inline Mutex fftw_planner_mutex;

}  // namespace isthmus::matching
