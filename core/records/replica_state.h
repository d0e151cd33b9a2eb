// The state of a server that only reads a map: how it keeps up with the one that writes it.
#pragma once

#include <string>

namespace isthmus {

struct ReplicaState {
  std::string owner;    // The map's writer, as the store has it: process and host. May be empty.
  double behind_s = 0;  // Since it last had all that the store holds.
  // Why the store cannot be followed at the moment, for people; empty while it can.
  std::string problem;
};

}  // namespace isthmus
