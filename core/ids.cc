#include "core/ids.h"

namespace isthmus {

std::string ToString(const SubmapId& id) {
  return id.session.value() + "/" + std::to_string(id.index);
}

}  // namespace isthmus
