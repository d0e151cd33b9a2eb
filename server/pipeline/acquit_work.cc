#include <string>

#include "server/pipeline.h"
#include "server/threads/work_journal.h"

namespace isthmus::server {

void Pipeline::AcquitWork(const std::string& work_journal) { WorkJournal::Acquit(work_journal); }

}  // namespace isthmus::server
