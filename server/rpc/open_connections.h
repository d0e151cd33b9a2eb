// The connections that a listener has handed over, as far as they are still open.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <vector>

namespace isthmus::rpc {

// Sockets that were handed over are closed without a word, and their numbers may be other files' by
// then: the system is asked, by a socket's own number (inode), which does not come again. Not
// thread safe.
class OpenConnections {
 public:
  explicit OpenConnections(size_t most) : most_(most) {}

  // False where so many are open. With more than some hundred open, closed ones may count for a few
  // attempts more: each looks at a part of them.
  bool Add(int socket);

 private:
  struct Connection {
    int file;
    ino_t inode;
  };

  void ForgetClosed();

  size_t most_;
  size_t next_ = 0;  // To be looked at.
  std::vector<Connection> connections_;
};

}  // namespace isthmus::rpc
