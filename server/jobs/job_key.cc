#include "server/jobs/job_key.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <vector>

namespace isthmus::server {
namespace {

std::optional<SubmapId> ParseSubmap(const std::string& text) {
  const size_t slash = text.rfind('/');
  SubmapId id;
  if (slash == std::string::npos || !absl::SimpleAtoi(text.substr(slash + 1), &id.index)) {
    return std::nullopt;
  }
  id.session = SessionId(text.substr(0, slash));
  return id;
}

struct ToWords {
  std::string operator()(const MatchKey& key) const {
    return absl::StrCat("match ", key.pair.first.value(), " ", key.pair.second.value());
  }
  std::string operator()(const IndexKey& key) const { return "index " + key.session.value(); }
  std::string operator()(const LoopKey& key) const { return "loops " + ToString(key.submap); }
  std::string operator()(const ShapeKey& key) const { return "shape " + key.session.value(); }
  std::string operator()(const RevisitsKey&) const { return "revisits"; }
};

struct ToSentence {
  std::string operator()(const MatchKey& key) const {
    return absl::StrCat("the match of ", key.pair.first.value(), " and ", key.pair.second.value());
  }
  std::string operator()(const IndexKey& key) const {
    return "the partners of " + key.session.value();
  }
  std::string operator()(const LoopKey& key) const {
    return "the loops of " + ToString(key.submap);
  }
  std::string operator()(const ShapeKey& key) const {
    return "the shape that loops give " + key.session.value();
  }
  std::string operator()(const RevisitsKey&) const { return "which submaps were seen again"; }
};

struct ToSessions {
  std::vector<SessionId> operator()(const MatchKey& key) const {
    return {key.pair.first, key.pair.second};
  }
  std::vector<SessionId> operator()(const IndexKey& key) const { return {key.session}; }
  std::vector<SessionId> operator()(const LoopKey& key) const { return {key.submap.session}; }
  std::vector<SessionId> operator()(const ShapeKey& key) const { return {key.session}; }
  std::vector<SessionId> operator()(const RevisitsKey&) const { return {}; }
};

}  // namespace

std::string ToText(const JobKey& key) { return std::visit(ToWords(), key); }

std::string Describe(const JobKey& key) { return std::visit(ToSentence(), key); }

std::vector<SessionId> SessionsOf(const JobKey& key) { return std::visit(ToSessions(), key); }

std::optional<JobKey> ParseJobKey(absl::string_view text) {
  const std::vector<std::string> words = absl::StrSplit(text, ' ');
  const std::string& kind = words[0];
  if (kind == "match" && words.size() == 3) {
    return MatchKey{{SessionId(words[1]), SessionId(words[2])}};
  }
  if (kind == "revisits" && words.size() == 1) return RevisitsKey{};
  if (words.size() != 2) return std::nullopt;
  if (kind == "index") return IndexKey{SessionId(words[1])};
  if (kind == "shape") return ShapeKey{SessionId(words[1])};
  if (kind != "loops") return std::nullopt;
  const std::optional<SubmapId> submap = ParseSubmap(words[1]);
  return submap ? std::optional<JobKey>(LoopKey{*submap}) : std::nullopt;
}

}  // namespace isthmus::server
