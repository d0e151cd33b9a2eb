// Lists that the server streams. Private to the library.
#pragma once

#include <absl/status/statusor.h>

#include "client/library/answer_bound.h"
#include "client/library/link.h"

namespace isthmus::client {

// Puts a list together, from the beginning with each attempt. ResourceExhausted where it is larger
// than ClientOptions::max_answer_bytes. `open` begins the stream and returns
// its reader; `add` takes one response after the other.
template <typename List, typename Response, typename Open>
absl::StatusOr<List> ReadList(Client::Link& link, const Open& open,
                              void (*add)(const Response&, List&)) {
  List list;
  absl::Status failure;  // Found on this side.
  const auto read = [&](Client::Link::Stubs& stubs, grpc::ClientContext& context) {
    list = {};
    AnswerBound bound(link.options().max_answer_bytes);
    auto reader = open(stubs, context);
    for (Response part; failure.ok() && reader->Read(&part);) {
      failure = bound.Add(part.ByteSizeLong());
      if (failure.ok()) {
        add(part, list);
      } else {
        context.TryCancel();
      }
    }
    return reader->Finish();
  };
  const absl::Status status = link.Call(link.options().transfer_timeout_s, read);
  if (!failure.ok()) return failure;
  if (!status.ok()) return status;
  return list;
}

}  // namespace isthmus::client
