#include "core/concurrency/thread_role.h"

#include <pthread.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace isthmus {

void NameThread(const std::string& name) {
  constexpr size_t kMaxName = 15;  // The kernel's, without the zero at the end.
  (void)pthread_setname_np(pthread_self(), name.substr(0, kMaxName).c_str());
}

void LowerPriority(int nice) {
  // Linux has a priority per thread, of which POSIX knows nothing.
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));
  if (getpriority(PRIO_PROCESS, thread) >= nice) return;
  (void)setpriority(PRIO_PROCESS, thread, nice);
}

}  // namespace isthmus
