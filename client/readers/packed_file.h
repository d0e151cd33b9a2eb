// Files that are compressed or packed as a whole.
#pragma once

#include <string>

namespace isthmus::readers {

// The command that unpacks what is at `path`, by the first bytes of the file or, in a folder, by
// the endings of its files: "gunzip -k drive.bag.gz". Empty for what is not packed by gzip, bzip2,
// xz, zstd, lz4, zip, 7z or tar, or cannot be read.
std::string UnpackCommand(const std::string& path);

}  // namespace isthmus::readers
