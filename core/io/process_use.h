// The use that this process makes of the machine.
#pragma once

#include "core/records/server_status.h"

namespace isthmus::io {

// Asks the system; some microseconds, and one more for each open file.
ProcessUse UseOfThisProcess();

}  // namespace isthmus::io
