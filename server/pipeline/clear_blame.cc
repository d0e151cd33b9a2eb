#include <string>

#include "server/pipeline.h"
#include "server/threads/crash_journal.h"

namespace isthmus::server {

void Pipeline::ClearBlame(const std::string& crash_journal) {
  CrashJournal::ClearBlame(crash_journal);
}

}  // namespace isthmus::server
