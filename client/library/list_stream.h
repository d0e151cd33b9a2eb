// Lists that the server streams. Private to the library.
#pragma once

#include <absl/status/statusor.h>

#include "client/library/link.h"

namespace isthmus::client {

// Puts a list together, from the beginning with each attempt. `open` begins the stream and returns
// its reader; `add` takes one response after the other.
template <typename List, typename Response, typename Open>
absl::StatusOr<List> ReadList(Client::Link& link, const Open& open,
                              void (*add)(const Response&, List&)) {
  List list;
  const auto read = [&](Client::Link::Stubs& stubs, grpc::ClientContext& context) {
    list = {};
    auto reader = open(stubs, context);
    Response part;
    while (reader->Read(&part)) add(part, list);
    return reader->Finish();
  };
  const absl::Status status = link.Call(link.options().transfer_timeout_s, read);
  if (!status.ok()) return status;
  return list;
}

}  // namespace isthmus::client
