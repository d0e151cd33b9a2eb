// Recordings in memory, to be cut off and damaged, and all that can still be read from them.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "client/readers/messages/message_file.h"
#include "tests/client/readers/messages/drive_formulas.h"

namespace isthmus::readers {

inline std::string LoadData(const std::string& name) {
  std::ifstream file(DataFile(name), std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  EXPECT_FALSE(bytes.str().empty()) << name;
  return bytes.str();
}

struct AllMessages {
  bool opened = false;
  std::vector<std::string> messages;  // Topic, time and bytes of each.
  std::vector<std::string> errors;
  std::vector<std::string> notes;
};

inline AllMessages ReadMessages(const std::shared_ptr<const MessageFile>& file) {
  AllMessages all;
  all.opened = true;
  all.notes = file->notes();
  std::vector<size_t> topics;
  for (size_t i = 0; i < file->topics().size(); ++i) topics.push_back(i);
  auto reader = file->OpenReader(topics);
  EXPECT_TRUE(reader.ok()) << reader.status();
  while (reader.ok() && all.errors.size() < 1000) {
    const auto message = (*reader)->Next();
    if (!message.ok()) {
      all.errors.emplace_back(message.status().message());
    } else if (!message->has_value()) {
      break;
    } else {
      all.messages.push_back(file->topics()[(*message)->topic].name + " " +
                             std::to_string((*message)->log_ns) + " " +
                             std::string((*message)->bytes));
    }
  }
  EXPECT_LT(all.errors.size(), 1000u) << "it does not end";
  return all;
}

inline AllMessages ReadBytes(const std::string& bytes) {
  auto file = OpenMessageBytes(BufferSource(bytes), "drive");
  if (!file.ok()) return {};
  return ReadMessages(*file);
}

// The number of messages of `all` in `some`, which may hold nothing else, in their order.
inline size_t CountKept(const std::vector<std::string>& all, const std::vector<std::string>& some) {
  size_t at = 0;
  for (const std::string& message : some) {
    while (at < all.size() && all[at] != message) ++at;
    EXPECT_LT(at, all.size()) << "a message that was never written: " << message.substr(0, 40);
    ++at;
  }
  return some.size();
}

}  // namespace isthmus::readers
