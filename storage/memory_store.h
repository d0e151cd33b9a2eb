// A store that lives as long as the process: for tests, and for the commands that need no server.
#pragma once

#include <memory>

#include "storage/map_store.h"

namespace isthmus::storage {

// Keeps submaps by shared pointer, so reading one back costs nothing.
std::unique_ptr<MapStore> MakeMemoryStore();

}  // namespace isthmus::storage
