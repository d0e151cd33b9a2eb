#include "client/readers/messages/joined_file.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

namespace isthmus::readers {
namespace {

using Files = std::vector<std::shared_ptr<const MessageFile>>;

class JoinedReader : public MessageReader {
 public:
  // `joined[i][t]`: what topic t of file i is in all.
  JoinedReader(Files files, std::vector<std::vector<size_t>> joined, std::set<size_t> wanted)
      : files_(std::move(files)), joined_(std::move(joined)), wanted_(std::move(wanted)) {}

  absl::StatusOr<std::optional<Message>> Next() override {
    while (true) {
      if (reader_ == nullptr) {
        if (next_file_ == files_.size()) return std::nullopt;
        absl::Status status = Open(next_file_++);
        if (!status.ok()) return status;
      }
      absl::StatusOr<std::optional<Message>> message = reader_->Next();
      if (!message.ok()) return message;
      if (message->has_value()) {
        (*message)->topic = joined_[next_file_ - 1][(*message)->topic];
        return message;
      }
      for (std::string& one : reader_->Assumptions()) assumptions_.push_back(std::move(one));
      reader_ = nullptr;
    }
  }
  std::vector<std::string> Assumptions() const override {
    std::vector<std::string> all = assumptions_;
    if (reader_ == nullptr) return all;
    for (std::string& one : reader_->Assumptions()) all.push_back(std::move(one));
    return all;
  }

 private:
  absl::Status Open(size_t file) {
    std::vector<size_t> topics;
    for (size_t i = 0; i < joined_[file].size(); ++i) {
      if (wanted_.contains(joined_[file][i])) topics.push_back(i);
    }
    absl::StatusOr<std::unique_ptr<MessageReader>> reader = files_[file]->OpenReader(topics);
    if (!reader.ok()) return reader.status();
    reader_ = *std::move(reader);
    return absl::OkStatus();
  }

  const Files files_;
  const std::vector<std::vector<size_t>> joined_;
  const std::set<size_t> wanted_;
  size_t next_file_ = 0;
  std::unique_ptr<MessageReader> reader_;
  std::vector<std::string> assumptions_;  // Made by readers of earlier files.
};

class JoinedFile : public MessageFile {
 public:
  JoinedFile(Files files, std::string kind, std::vector<std::string> notes,
             const std::map<std::string, uint64_t>& counts)
      : files_(std::move(files)), kind_(std::move(kind)), notes_(std::move(notes)) {
    std::map<std::tuple<std::string, std::string, std::string>, std::optional<uint64_t>> sorted;
    const auto key = [](const MessageTopic& topic) {
      return std::make_tuple(topic.name, topic.type, topic.encoding);
    };
    for (const auto& file : files_) {
      for (const MessageTopic& topic : file->topics()) {
        const auto [place, is_new] = sorted.emplace(key(topic), uint64_t{0});
        std::optional<uint64_t>& sum = place->second;
        sum = sum && topic.messages ? std::optional(*sum + *topic.messages) : std::nullopt;
      }
      for (std::string& note : file->notes()) notes_.push_back(std::move(note));
    }
    for (const auto& file : files_) {
      joined_.emplace_back();
      for (const MessageTopic& topic : file->topics()) {
        joined_.back().push_back(std::distance(sorted.begin(), sorted.find(key(topic))));
      }
    }
    for (const auto& [names, messages] : sorted) {
      topics_.push_back({std::get<0>(names), std::get<1>(names), std::get<2>(names), messages});
      const auto count = counts.find(topics_.back().name);
      if (!messages && count != counts.end()) topics_.back().messages = count->second;
    }
  }

  std::string kind() const override { return kind_; }
  const std::vector<MessageTopic>& topics() const override { return topics_; }
  std::vector<std::string> notes() const override { return notes_; }
  absl::StatusOr<std::unique_ptr<MessageReader>> OpenPacked(
      std::vector<size_t> topics) const override {
    return std::make_unique<JoinedReader>(files_, joined_,
                                          std::set<size_t>(topics.begin(), topics.end()));
  }

 private:
  const Files files_;
  const std::string kind_;
  std::vector<std::string> notes_;
  std::vector<MessageTopic> topics_;
  std::vector<std::vector<size_t>> joined_;
};

}  // namespace

std::shared_ptr<const MessageFile> JoinFiles(Files files, std::string kind,
                                             std::vector<std::string> notes,
                                             const std::map<std::string, uint64_t>& messages) {
  return std::make_shared<JoinedFile>(std::move(files), std::move(kind), std::move(notes),
                                      messages);
}

}  // namespace isthmus::readers
