#include "server/rpc/streams/stream_host.h"

namespace isthmus::rpc {

void StreamHost::Enter(StoppableStream* stream) {
  MutexLock lock(&mutex_);
  streams_.insert(stream);
  if (stopped_) stream->Stop();
}

void StreamHost::Leave(StoppableStream* stream) {
  MutexLock lock(&mutex_);
  streams_.erase(stream);
}

void StreamHost::StopAll() {
  MutexLock lock(&mutex_);
  stopped_ = true;
  for (StoppableStream* stream : streams_) stream->Stop();
}

}  // namespace isthmus::rpc
