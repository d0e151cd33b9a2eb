// The configuration file: settings that are read, refused with their line, and read back as
// printed.
#include "server/main/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>

#include "server/main/settings.h"

namespace isthmus::server {
namespace {

using testing::HasSubstr;

std::string ErrorOf(const std::string& yaml) {
  const auto config = ParseConfig(yaml);
  if (config.ok()) return "no error";
  EXPECT_TRUE(absl::IsInvalidArgument(config.status()));
  return std::string(config.status().message());
}

TEST(ConfigTest, AnEmptyFileIsAllDefaults) {
  for (const char* yaml : {"", "# nothing\n", "ingest:\n"}) {
    const auto config = ParseConfig(yaml);
    ASSERT_TRUE(config.ok()) << config.status();
    EXPECT_EQ(PrintConfig(*config), PrintConfig(ServerConfig()));
  }
}

TEST(ConfigTest, EveryKindOfValueIsRead) {
  const auto config = ParseConfig(
      "network: {listen: '0.0.0.0:7000', max_submap_bytes: 100000}\n"
      "storage:\n  sync_every_commit: false\n"
      "ingest:\n  scan_queue: 3\n"
      "odometry:\n  mode: floam\n"
      "matching:\n  search: paper\n  min_probability: 0.99\n");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->rpc.listen, "0.0.0.0:7000");
  EXPECT_EQ(config->rpc.max_submap_bytes, 100000u);
  EXPECT_FALSE(config->storage.sync_every_commit);
  EXPECT_EQ(config->pipeline.scan_queue, 3u);
  EXPECT_EQ(config->pipeline.odometry.mode, OdometryMode::kFloam);
  EXPECT_EQ(config->pipeline.matcher.search, matching::SearchMode::kPaper);
  EXPECT_EQ(config->pipeline.matcher.min_probability, 0.99);
  // Settings that are not named keep their defaults.
  EXPECT_EQ(config->pipeline.ingest_threads, PipelineOptions().ingest_threads);
}

TEST(ConfigTest, AServerStandsByOnlyWhereItIsToldTo) {
  EXPECT_FALSE(ServerConfig().standby);
  const auto config =
      ParseConfig("storage: {store: 'postgresql://db/isthmus', standby: true, lease_s: 2.5}\n");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_TRUE(config->standby);
  EXPECT_FALSE(config->replica);
  EXPECT_TRUE(ParseConfig("storage: {replica: true}\n")->replica);
  EXPECT_EQ(config->lease_s, 2.5);
  EXPECT_EQ(PrintConfig(*ParseConfig(PrintConfig(*config))), PrintConfig(*config));
  EXPECT_THAT(ErrorOf("storage: {lease_s: 0.5}\n"), HasSubstr("from 1 to 3600"));
  EXPECT_THAT(ErrorOf("sites: {yard: {storage: {standby: true}}}\n"),
              HasSubstr("unknown section storage"));
}

TEST(ConfigTest, MetricsAreOffUntilTheyHaveAnAddress) {
  EXPECT_EQ(ServerConfig().metrics.listen, "");
  const auto config = ParseConfig("metrics: {listen: '0.0.0.0:9464', insecure: true, robots: 7}\n");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->metrics.listen, "0.0.0.0:9464");
  EXPECT_TRUE(config->metrics.insecure);
  EXPECT_EQ(config->metrics.robots, 7);
  // They are of the server as a whole.
  EXPECT_THAT(ErrorOf("sites: {yard: {metrics: {robots: 1}}}\n"),
              HasSubstr("unknown section metrics"));
}

TEST(ConfigTest, BrowsersAreServedOnlyAtAnAddressThatIsNamed) {
  EXPECT_EQ(ServerConfig().web.listen, "");
  const auto config =
      ParseConfig("web: {listen: '0.0.0.0:8080', insecure: true, hosts: 'maps.example b'}\n");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->web.listen, "0.0.0.0:8080");
  EXPECT_TRUE(config->web.insecure);
  EXPECT_EQ(config->web.hosts, "maps.example b");
  for (const char* hosts : {"\"\\xff\\xfe\"", "\xC3\xA4", "\"a\\nb\""}) {
    EXPECT_THAT(ErrorOf(std::string("web: {hosts: ") + hosts + "}\n"), HasSubstr("web.hosts"));
  }
  EXPECT_THAT(ErrorOf("sites: {yard: {web: {insecure: true}}}\n"),
              HasSubstr("unknown section web"));
}

TEST(ConfigTest, EveryLimitOfAcceptanceCanBeSet) {
  const auto config = ParseConfig(
      "matching:\n"
      "  rematch_submaps: 4\n"
      "  min_probability: 0.95\n"
      "  twins: exact\n"
      "  min_observability: 0.04\n"
      "  max_odometry_residual: 2.5\n");
  ASSERT_TRUE(config.ok()) << config.status();
  const matching::MatcherOptions& matcher = config->pipeline.matcher;
  EXPECT_EQ(config->pipeline.rematch_submaps, 4);
  EXPECT_EQ(matcher.min_probability, 0.95);
  EXPECT_EQ(matcher.twins, matching::Twins::kExact);
  EXPECT_EQ(matcher.min_observability, 0.04);
  EXPECT_EQ(matcher.max_odometry_residual, 2.5);
}

// Each limit comes with its meaning, so that nobody has to guess.
TEST(ConfigTest, EveryLimitOfAcceptanceIsPrintedBelowItsMeaning) {
  const std::string printed = PrintConfig(ServerConfig());
  for (const char* key : {"rematch_submaps", "min_probability", "twins", "min_observability",
                          "max_odometry_residual"}) {
    const size_t at = printed.find("\n  " + std::string(key) + ": ");
    ASSERT_NE(at, std::string::npos) << key;
    const size_t line = printed.rfind('\n', at - 1) + 1;
    EXPECT_THAT(printed.substr(line, at - line), testing::StartsWith("  # ")) << key;
  }
}

TEST(ConfigTest, WhatIsKeptOfRobotsCanBeSet) {
  const auto config = ParseConfig(
      "archive:\n"
      "  mode: rounded\n"
      "  required: false\n"
      "retention:\n"
      "  quota_bytes: 20000000000\n"
      "  over_quota: drop_oldest\n"
      "  max_age_days: 30\n"
      "  robots: alice=5000000000:7.5 bob=0\n");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->pipeline.archive.mode, ArchiveMode::kRounded);
  EXPECT_FALSE(config->pipeline.archive.required);
  const RetentionOptions& retention = config->pipeline.retention;
  EXPECT_EQ(retention.over_quota, OverQuota::kDropOldest);
  EXPECT_EQ(retention.LimitsOf(RobotId("carol")).quota_bytes, 20'000'000'000u);
  EXPECT_EQ(retention.LimitsOf(RobotId("carol")).max_age_days, 30);
  EXPECT_EQ(retention.LimitsOf(RobotId("alice")).quota_bytes, 5'000'000'000u);
  EXPECT_EQ(retention.LimitsOf(RobotId("alice")).max_age_days, 7.5);
  EXPECT_EQ(retention.LimitsOf(RobotId("bob")).quota_bytes, 0u);
  EXPECT_EQ(retention.LimitsOf(RobotId("bob")).max_age_days, 0);
  EXPECT_EQ(PrintConfig(*ParseConfig(PrintConfig(*config))), PrintConfig(*config));
  for (const char* robots : {"alice", "alice=", "=5", "alice=-1", "alice=1:nan", "alice=1:1e-300",
                             "alice=1:2:3", "alice=1 alice=2", "alice=many"}) {
    EXPECT_THAT(ErrorOf("retention:\n  robots: \"" + std::string(robots) + "\"\n"),
                HasSubstr("retention.robots"));
  }
}

TEST(ConfigTest, WhatIsPrintedReadsBackToTheSame) {
  ServerConfig config;
  config.rpc.listen = "unix:/run/\"odd\\name\"";
  config.storage.resolution_m = 0.1 / 3;
  config.pipeline.composition_interval_s = 0.3;
  config.pipeline.odometry.mode = OdometryMode::kFloam;
  config.pipeline.submap.cut_scans = 123;
  const std::string printed = PrintConfig(config);
  const auto read = ParseConfig(printed);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(PrintConfig(*read), printed);
  EXPECT_EQ(read->rpc.listen, config.rpc.listen);
  EXPECT_EQ(read->storage.resolution_m, config.storage.resolution_m);
  EXPECT_EQ(read->pipeline.submap.cut_scans, 123);
}

TEST(ConfigTest, SitesHaveSettingsOfTheirOwnInPlaceOfTheRest) {
  const auto config = ParseConfig(
      "sites:\n  yard:\n    retention: {quota_bytes: 5}\n  hall: {}\n  shed:\n"
      "retention: {quota_bytes: 7, max_age_days: 3}\nnetwork: {require_token: always}\n");
  ASSERT_TRUE(config.ok()) << config.status();
  ASSERT_EQ(config->sites.size(), 3u);
  EXPECT_EQ(config->sites.at("yard").retention.limits.quota_bytes, 5u);
  EXPECT_EQ(config->sites.at("yard").retention.limits.max_age_days, 3);
  EXPECT_EQ(config->sites.at("hall").retention.limits.quota_bytes, 7u);
  EXPECT_EQ(config->pipeline.retention.limits.quota_bytes, 7u);
  EXPECT_EQ(config->rpc.require_token, access::RequireToken::kAlways);
  const std::string printed = PrintConfig(*config);
  const auto read = ParseConfig(printed);
  ASSERT_TRUE(read.ok()) << read.status() << printed;
  EXPECT_EQ(PrintConfig(*read), printed);
  EXPECT_EQ(read->sites.at("yard").retention.limits.quota_bytes, 5u);
}

TEST(ConfigTest, SitesThatCannotBe) {
  EXPECT_THAT(ErrorOf("sites: [yard]\n"), HasSubstr("sites must be names"));
  for (const char* name : {"../up", ".hidden", "a/b", "default", "\"\"", "\"two words\""}) {
    EXPECT_THAT(ErrorOf("sites:\n  " + std::string(name) + ": {}\n"), HasSubstr("line 2"));
  }
  EXPECT_THAT(ErrorOf("sites:\n  yard: {}\n  yard: {}\n"), HasSubstr("twice"));
  EXPECT_THAT(ErrorOf("sites: {}\nsites: {}\n"), HasSubstr("twice"));
  EXPECT_THAT(ErrorOf("sites:\n  yard: {network: {listen: 'a:1'}}\n"),
              testing::AllOf(HasSubstr("site yard"), HasSubstr("network")));
  EXPECT_THAT(ErrorOf("sites:\n  yard: {retention: {quota_bytes: x}}\n"),
              HasSubstr("retention.quota_bytes"));
}

TEST(ConfigTest, UnknownNamesAreNamedWithTheirLineAndTheKnownOnes) {
  EXPECT_THAT(
      ErrorOf("ingest:\n  scan_queue: 4\n  scan_quue: 3\n"),
      testing::AllOf(HasSubstr("line 3"), HasSubstr("ingest.scan_quue"), HasSubstr("scan_queue")));
  EXPECT_THAT(ErrorOf("ingst:\n  threads: 1\n"),
              testing::AllOf(HasSubstr("ingst"), HasSubstr("ingest"), HasSubstr(", sites")));
  EXPECT_THAT(ErrorOf("sites:\n  yard:\n    ingst: {}\n"), testing::Not(HasSubstr(", sites")));
}

// A server starts with the file of an older version.
TEST(ConfigTest, SettingsOfEarlierVersionsAreLeftOutWithAWarning) {
  const auto config = ParseConfig(
      "network:\n  max_exports: 7\n  max_queries: 5\n"
      "sites:\n  yard:\n    odometry: {map_radius_m: not even a number}\n");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->rpc.calls.queries, 5u);
  ASSERT_EQ(config->warnings.size(), 2u);
  EXPECT_EQ(config->warnings[0],
            "line 2: network.max_exports is no longer a setting and does nothing: remove it");
  EXPECT_THAT(config->warnings[1],
              testing::AllOf(HasSubstr("line 6"), HasSubstr("odometry.map_radius_m")));
  EXPECT_THAT(ErrorOf("network: {max_exprots: 7}\n"), HasSubstr("unknown setting"));
  ServerConfig known;
  for (const Setting& setting : SettingsOf(known)) {
    EXPECT_FALSE(WasSetting(setting.section + "." + setting.key)) << setting.key;
  }
}

TEST(ConfigTest, EachSettingHasAReasonToChangeItInTheDocument) {
  std::ifstream file(ISTHMUS_SOURCE "/docs/tuning.md");
  ASSERT_TRUE(file);
  std::string document(std::istreambuf_iterator<char>(file), {});
  document.erase(0, document.find("\n## Why change a setting\n"));
  static const std::regex kRow(R"(\n\| (`[a-z]+\.[^|]*`) \| \w[^|]*(?= \|))"),
      kName(R"([a-z]+\.[a-z0-9_]+)");
  const auto each = [](const std::string& text, const std::regex& what) {
    return std::pair(std::sregex_iterator(text.begin(), text.end(), what), std::sregex_iterator());
  };
  std::multiset<std::string> documented, settings;
  for (auto [row, end] = each(document, kRow); row != end; ++row) {
    const std::string names = row->str(1);
    for (auto [name, last] = each(names, kName); name != last; ++name) {
      documented.insert(name->str());
    }
  }
  ServerConfig config;
  for (const Setting& setting : SettingsOf(config)) {
    settings.insert(setting.section + "." + setting.key);
  }
  EXPECT_EQ(documented, settings);
}

TEST(ConfigTest, ValuesOfTheWrongTypeOrOutOfRangeAreNamed) {
  for (const char* value : {"-1", "1.5", "many", "", "99999999999999999999"}) {
    EXPECT_THAT(ErrorOf("ingest:\n  threads: \"" + std::string(value) + "\"\n"),
                testing::AllOf(HasSubstr("line 2"), HasSubstr("ingest.threads"),
                               HasSubstr("from 0 to 256")));
  }
  for (const char* value : {".nan", "nan", "inf", "0", "1e9"}) {
    EXPECT_THAT(ErrorOf("composition:\n  voxel_m: " + std::string(value) + "\n"),
                HasSubstr("composition.voxel_m"));
  }
  EXPECT_THAT(ErrorOf("storage:\n  sync_every_commit: maybe\n"), HasSubstr("true, false"));
  EXPECT_THAT(ErrorOf("matching:\n  twins: many\n"), HasSubstr("rare, possible, exact"));
  EXPECT_THAT(ErrorOf("odometry:\n  mode: aloam\n"), HasSubstr("floam, continuous"));
  EXPECT_THAT(ErrorOf("network:\n  listen: \"\"\n"), HasSubstr("network.listen"));
  for (const char* limit :
       {"min_probability: 0", "max_odometry_residual: 0", "min_observability: 2"}) {
    const std::string key(limit, std::string(limit).find(':'));
    EXPECT_THAT(ErrorOf("matching:\n  " + std::string(limit) + "\n"),
                testing::AllOf(HasSubstr("matching." + key), HasSubstr("give a number from")));
  }
}

// A robot would wait for ever, and a session go as soon as it is finished.
TEST(ConfigTest, ALimitIsNotSoSmallThatNothingPassesIt) {
  for (const char* value : {"1e-300", "4.9e-324", "0.000001", "-1", "nan", "many"}) {
    EXPECT_THAT(ErrorOf("ingest:\n  max_scan_rate_hz: " + std::string(value) + "\n"),
                HasSubstr("give 0, or a number from 0.01 to 10000"));
    EXPECT_THAT(ErrorOf("retention:\n  max_age_days: " + std::string(value) + "\n"),
                HasSubstr("give 0, or a number from 1e-05 to 36500"));
  }
  for (const double hz : {0.0, 0.01, 10.0}) {
    const auto config = ParseConfig("ingest: {max_scan_rate_hz: " + std::to_string(hz) + "}\n");
    ASSERT_TRUE(config.ok()) << config.status();
    EXPECT_EQ(config->pipeline.max_scan_rate_hz, hz);
  }
}

TEST(ConfigTest, AnErrorFoundLaterHasThePlaceOfTheSetting) {
  const auto config = ParseConfig("storage:\n  bucket: 'nonsense'\n");
  ASSERT_TRUE(config.ok()) << config.status();
  const absl::Status wrong = absl::InvalidArgumentError("this is no URL");
  EXPECT_EQ(AtPlace(*config, "storage.bucket", wrong),
            absl::InvalidArgumentError("line 2: this is no URL"));
  EXPECT_EQ(AtPlace(*config, "storage.store", wrong), wrong);
  EXPECT_TRUE(AtPlace(*config, "storage.bucket", absl::OkStatus()).ok());
}

TEST(ConfigTest, AFileHasOneDocument) {
  EXPECT_THAT(ErrorOf("ingest:\n  threads: 1\n---\ningest:\n  threads: 2\n"),
              testing::AllOf(HasSubstr("line 4"), HasSubstr("second document")));
  for (const char* yaml : {"---\ningest: {threads: 1}\n", "ingest: {threads: 1}\n---\n",
                           "# ours\n---\ningest: {threads: 1}\n...\n"}) {
    const auto config = ParseConfig(yaml);
    ASSERT_TRUE(config.ok()) << config.status();
    EXPECT_EQ(config->pipeline.ingest_threads, 1);
  }
}

TEST(ConfigTest, TextOfTheWrongShape) {
  EXPECT_THAT(ErrorOf("just text"), HasSubstr("sections"));
  EXPECT_THAT(ErrorOf("- a\n- b\n"), HasSubstr("sections"));
  EXPECT_THAT(ErrorOf("ingest: 4\n"), HasSubstr("ingest must hold settings"));
  EXPECT_THAT(ErrorOf("ingest:\n  threads: [1, 2]\n"), HasSubstr("single value"));
  EXPECT_THAT(ErrorOf("ingest:\n  threads: 1\n  threads: 2\n"), HasSubstr("twice"));
  EXPECT_THAT(ErrorOf("ingest: {}\ningest: {}\n"), HasSubstr("twice"));
  EXPECT_THAT(ErrorOf("ingest: {threads: 1\n"), HasSubstr("not YAML"));
  EXPECT_THAT(ErrorOf("? [a, b]\n: c\n"), HasSubstr("unknown section"));
}

TEST(ConfigTest, AFileThatCannotBeReadIsNamed) {
  for (const std::string& path : {std::string("no/such/file.yaml"), testing::TempDir()}) {
    const auto config = LoadConfig(path);
    EXPECT_TRUE(absl::IsNotFound(config.status())) << config.status();
    EXPECT_THAT(std::string(config.status().message()), HasSubstr(path));
  }
}

}  // namespace
}  // namespace isthmus::server
