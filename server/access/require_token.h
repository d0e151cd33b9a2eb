// The choice of when a server asks its callers for a token.
#pragma once

namespace isthmus::access {

enum class RequireToken {
  kAuto,    // As soon as there is any token.
  kAlways,  // Also while there is none: nobody is let in then.
  kNever,   // Tokens count for nothing: something in front of the server lets callers in.
};

}  // namespace isthmus::access
