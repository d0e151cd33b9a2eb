#include "core/caught.h"

#include <absl/strings/str_cat.h>

#include <exception>
#include <new>

namespace isthmus {

absl::Status CaughtStatus() {
  try {
    throw;
  } catch (const StatusError& e) {
    return e.status();
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError("the server has not enough memory for it");
  } catch (const std::exception& e) {
    return absl::InternalError(absl::StrCat("the server failed at it (", e.what(), ")"));
  } catch (...) {
    return absl::InternalError("the server failed at it");
  }
}

}  // namespace isthmus
