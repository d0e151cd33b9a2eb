#include "client/readers/folder/folder_recording.h"
#include "client/readers/messages/message_recording.h"
#include "client/readers/recording.h"

namespace isthmus::readers {

absl::StatusOr<std::unique_ptr<Recording>> OpenRecording(const std::string& path) {
  if (IsMessageFile(path)) return OpenMessageRecording(path, {});
  return OpenFolderRecording(path);
}

}  // namespace isthmus::readers
