#include "core/concurrency/thread_role.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <thread>

namespace isthmus {
namespace {

int Nice() { return getpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid))); }

TEST(ThreadRole, OneThreadGivesWayAndOthersDoNot) {
  const int before = Nice();
  std::thread thread([before] {
    LowerPriority(before + 3);
    EXPECT_EQ(Nice(), before + 3);
    LowerPriority(before + 1);  // Only ever more.
    EXPECT_EQ(Nice(), before + 3);
  });
  thread.join();
  EXPECT_EQ(Nice(), before);
}

TEST(ThreadRole, LongNamesAreCut) {
  std::thread thread([] {
    NameThread("composition-of-maps");
    char name[32];
    ASSERT_EQ(pthread_getname_np(pthread_self(), name, sizeof(name)), 0);
    EXPECT_STREQ(name, "composition-of-");
  });
  thread.join();
}

}  // namespace
}  // namespace isthmus
