// Descriptions of the metrics agree with the server: docs/metrics.md names all of them, and the
// dashboard and the alerts ask for no others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>

#include "tests/server/metrics/measured_server.h"

namespace isthmus::metrics {
namespace {

using Names = std::set<std::string>;

std::string ReadWhole(const std::string& path) {
  std::ifstream file(std::string(ISTHMUS_SOURCE) + "/" + path);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// The names of metrics in a text, without what a histogram's series have behind theirs.
Names NamesIn(const std::string& text) {
  static const std::regex kName(R"(\b(?:isthmus|process)_[a-z_]+[a-z]\b(?!\.|\())"),
      kSeries("_(bucket|sum|count)$");
  Names names;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), kName);
       it != std::sregex_iterator(); ++it) {
    names.insert(std::regex_replace(it->str(), kSeries, ""));
  }
  return names;
}

// Every string below a key of that name.
void CollectStrings(const nlohmann::json& node, const std::string& key, Names* strings) {
  for (const auto& [name, value] : node.items()) {
    if (value.is_string() && name == key) strings->insert(value.get<std::string>());
    if (value.is_structured()) CollectStrings(value, key, strings);
  }
}

// The metrics of a server that has done something of everything.
const Names& Exported() {
  static const Names* const exported = [] {
    MeasuredServer server;
    server.Drive("alice", 12);
    server.Drive("bob", 12);
    server.Stream(server.stubs->NewSession("carol"), {rpc::RoomScan("", 1)});
    server.pipeline->WaitUntilIdle();
    const auto localised =
        server.pipeline->OpenLocaliser({.sensor = "vlp16", .robot = RobotId("dave")});
    EXPECT_TRUE(localised.ok()) << localised.status();
    return new Names(server.Ask().families());
  }();
  return *exported;
}

TEST(MetricNamesTest, TheDocumentNamesEachThatThereIsAndNoOther) {
  Names documented;
  const std::string document = ReadWhole("docs/metrics.md");
  static const std::regex kRow(R"(\n\| `([a-z_]+)` \|)");
  for (auto it = std::sregex_iterator(document.begin(), document.end(), kRow);
       it != std::sregex_iterator(); ++it) {
    if (it->str(1).find("_") != std::string::npos) documented.insert(it->str(1));
  }
  std::erase_if(documented, [](const std::string& name) { return name == "loop_search"; });
  EXPECT_EQ(documented, Exported());
  for (const std::string& name : NamesIn(document)) EXPECT_TRUE(Exported().contains(name)) << name;
}

TEST(MetricNamesTest, TheDashboardAsksForWhatThereIs) {
  const nlohmann::json dashboard =
      nlohmann::json::parse(ReadWhole("cmake/install/files/metrics/grafana-dashboard.json"));
  Names expressions;
  CollectStrings(dashboard["panels"], "expr", &expressions);
  CollectStrings(dashboard["templating"], "query", &expressions);
  EXPECT_GT(expressions.size(), 40u);
  Names asked;
  for (const std::string& expression : expressions) asked.merge(NamesIn(expression));
  EXPECT_GT(asked.size(), 25u);
  for (const std::string& name : asked) EXPECT_TRUE(Exported().contains(name)) << name;
}

TEST(MetricNamesTest, TheAlertsAskForWhatThereIs) {
  const YAML::Node rules =
      YAML::Load(ReadWhole("cmake/install/files/metrics/prometheus-alerts.yaml"));
  size_t alerts = 0;
  for (const auto& group : rules["groups"]) {
    for (const auto& rule : group["rules"]) {
      ++alerts;
      const Names asked = NamesIn(rule["expr"].as<std::string>());
      EXPECT_TRUE(!asked.empty() || rule["alert"].as<std::string>() == "IsthmusDown");
      for (const std::string& name : asked) EXPECT_TRUE(Exported().contains(name)) << name;
    }
  }
  EXPECT_GT(alerts, 5u);
}

// The rules of Prometheus' own check of names.
TEST(MetricNamesTest, NamesFollowPrometheusConventions) {
  static const std::regex kPlain("[a-z]+(_[a-z]+)+");
  for (const std::string& name : Exported()) {
    EXPECT_TRUE(std::regex_match(name, kPlain)) << name;
    EXPECT_TRUE(name.starts_with("isthmus_") || name.starts_with("process_")) << name;
  }
}

}  // namespace
}  // namespace isthmus::metrics
