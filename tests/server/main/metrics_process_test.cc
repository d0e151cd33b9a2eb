// isthmus-server as a process whose metrics are fetched, and the settings with which it does not
// start.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/main/child_process.h"
#include "tests/server/metrics/scrape.h"
#include "tests/server/rpc/stubs.h"

namespace isthmus {
namespace {

using testing::HasSubstr;

class MetricsProcessTest : public testing::Test {
 protected:
  MetricsProcessTest() {
    folder_ = testing::TempDir() + "isthmus-metrics-XXXXXX";
    if (mkdtemp(folder_.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
  }
  ~MetricsProcessTest() override {
    server_.reset();
    other_.reset();
    std::filesystem::remove_all(folder_);
  }

  std::unique_ptr<ChildProcess> Start(const std::string& data, const std::string& settings) const {
    const std::string path = folder_ + "/" + data;
    std::ofstream(path + ".yaml") << settings;
    return std::make_unique<ChildProcess>(
        ISTHMUS_SERVER,
        std::vector<std::string>{"--data", path, "--listen", "127.0.0.1:0", "--config",
                                 path + ".yaml"},
        path + ".stderr");
  }
  // The address of the process's metrics, as its log says; it listens.
  static std::string AddressIn(const std::string& log) {
    const std::string begin = "metrics at http://";
    const size_t at = log.find(begin), end = log.find("/metrics\n", at);
    if (at == std::string::npos || end == std::string::npos) return "";
    return log.substr(at + begin.size(), end - at - begin.size());
  }

  std::string folder_;
  std::unique_ptr<ChildProcess> server_, other_;
};

TEST_F(MetricsProcessTest, AServersMetricsAreFetchedWhileItServesAndNotAfter) {
  server_ = Start("a", "metrics: {listen: 'localhost:0'}\nsites: {yard: {}}\n");
  const std::string line = server_->ReadLine();
  const std::string listening = "isthmus-server listening on ";
  ASSERT_TRUE(line.starts_with(listening)) << server_->Errors();
  const rpc::Stubs stubs(
      grpc::CreateChannel(line.substr(listening.size()), grpc::InsecureChannelCredentials()));
  v1::MapInfo info;
  EXPECT_GRPC_OK(stubs.map->GetMapInfo(rpc::NewContext().get(), {}, &info));

  const std::string address = AddressIn(server_->Errors());
  ASSERT_NE(address, "") << server_->Errors();
  const auto scrape = metrics::Scrape::Of(address);
  EXPECT_EQ(
      scrape.Sum("isthmus_rpc_duration_seconds_count", {{"method", "GetMapInfo"}, {"code", "OK"}}),
      1);
  for (const char* site : {"default", "yard"}) {
    EXPECT_EQ(scrape.Sum("isthmus_sessions_open", {{"site", site}}), 0) << site;
    EXPECT_GT(scrape.Sum("isthmus_disk_used_bytes", {{"site", site}, {"kind", "database"}}), 0);
    EXPECT_GT(scrape.Sum("isthmus_disk_free_bytes", {{"site", site}}), 0);
  }
  server_->Signal(SIGTERM);
  EXPECT_EQ(server_->Wait(), 0) << server_->Errors();
  EXPECT_EQ(metrics::Ask(address, "GET /metrics"), "");
}

TEST_F(MetricsProcessTest, APortInUseEndsTheStart) {
  server_ = Start("a", "metrics: {listen: '127.0.0.1:0'}\n");
  server_->ReadLine();
  const std::string address = AddressIn(server_->Errors());
  ASSERT_NE(address, "") << server_->Errors();
  other_ = Start("b", "metrics: {listen: '" + address + "'}\n");
  EXPECT_EQ(other_->Wait(), 4);
  EXPECT_THAT(other_->Errors(), HasSubstr("cannot listen at " + address));
}

TEST_F(MetricsProcessTest, OtherMachinesAreLetInOnlyWhereTheSettingsSaySo) {
  server_ = Start("a", "metrics: {listen: '0.0.0.0:0'}\n");
  EXPECT_EQ(server_->Wait(), 2);
  EXPECT_THAT(server_->Errors(), HasSubstr("metrics.insecure: true"));
  server_ = Start("a", "metrics: {listen: '0.0.0.0:0', insecure: true}\n");
  EXPECT_THAT(server_->ReadLine(), HasSubstr("listening")) << server_->Errors();
}

}  // namespace
}  // namespace isthmus
