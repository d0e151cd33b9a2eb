// Names of sites: the maps that one server keeps apart.
#pragma once

#include <string>

namespace isthmus {

// The site whose map lies in the data folder itself.
inline constexpr char kDefaultSite[] = "default";

// Up to 64 of [A-Za-z0-9_.-], no dot in front: it names a folder, and a schema of a database.
bool IsSiteName(const std::string& name);

}  // namespace isthmus
