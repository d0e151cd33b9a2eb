#include "server/rpc/open_connections.h"

#include <sys/stat.h>

#include <algorithm>

namespace isthmus::rpc {
namespace {

// Connections looked at for one that comes when there are too many: a tenth of a millisecond.
constexpr size_t kLooks = 512;

// 0 where there is no such file.
ino_t InodeOf(int file) {
  struct stat about = {};
  return fstat(file, &about) == 0 ? about.st_ino : 0;
}

}  // namespace

bool OpenConnections::Add(int socket) {
  if (connections_.size() >= most_) ForgetClosed();
  if (connections_.size() >= most_) return false;
  connections_.push_back({socket, InodeOf(socket)});
  return true;
}

void OpenConnections::ForgetClosed() {
  for (size_t looks = std::min(kLooks, connections_.size()); looks > 0; --looks) {
    if (next_ >= connections_.size()) next_ = 0;
    Connection& one = connections_[next_];
    if (InodeOf(one.file) == one.inode) {
      ++next_;
    } else {
      one = connections_.back();
      connections_.pop_back();
    }
  }
}

}  // namespace isthmus::rpc
