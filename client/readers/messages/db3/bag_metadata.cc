#include "client/readers/messages/db3/bag_metadata.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <yaml-cpp/yaml.h>

#include <filesystem>

namespace isthmus::readers {
namespace {

// Throws what yaml-cpp does.
BagMetadata ReadMetadata(const YAML::Node& bag) {
  BagMetadata metadata;
  for (const YAML::Node& file : bag["relative_file_paths"]) {
    // The first recorders wrote them with the bag's own folder.
    metadata.files.push_back(std::filesystem::path(file.as<std::string>()).filename().string());
  }
  metadata.compression_mode =
      absl::AsciiStrToUpper(bag["compression_mode"].as<std::string>(std::string()));
  metadata.compression_format = bag["compression_format"].as<std::string>(std::string());
  for (const YAML::Node& topic : bag["topics_with_message_count"]) {
    metadata.messages[topic["topic_metadata"]["name"].as<std::string>()] +=
        topic["message_count"].as<uint64_t>();
  }
  return metadata;
}

}  // namespace

absl::StatusOr<BagMetadata> ParseBagMetadata(const std::string& yaml) {
  try {
    const YAML::Node root = YAML::Load(yaml);
    if (root.IsMap() && root["rosbag2_bagfile_information"].IsMap()) {
      return ReadMetadata(root["rosbag2_bagfile_information"]);
    }
  } catch (const YAML::Exception& error) {
    return absl::InvalidArgumentError(absl::StrCat("it is damaged: ", error.what()));
  }
  return absl::InvalidArgumentError("it is not that of a ROS 2 bag");
}

}  // namespace isthmus::readers
