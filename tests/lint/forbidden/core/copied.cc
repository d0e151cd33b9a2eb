#include <string>
#include <vector>

size_t Length(const std::vector<std::string>& words) {
  size_t length = 0;
  for (const std::string word : words) length += word.size();
  return length;
}
