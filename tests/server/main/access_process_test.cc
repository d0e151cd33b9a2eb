// isthmus-server as a process: tokens in its folder, and several sites.
#include <signal.h>

#include <filesystem>
#include <fstream>

#include "core/io/file_io.h"
#include "server/access/tokens.h"
#include "tests/server/main/child_process.h"
#include "tests/server/rpc/stubs.h"

namespace isthmus {
namespace {

using rpc::Merged;
using rpc::NewContext;
using rpc::Stubs;
using testing::HasSubstr;

class AccessProcessTest : public testing::Test {
 protected:
  AccessProcessTest() {
    std::string pattern = testing::TempDir() + "isthmus-sites-XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
    folder_ = pattern;
  }
  ~AccessProcessTest() override {
    server_.reset();
    std::filesystem::remove_all(folder_);
  }

  std::string Path(const std::string& name) const { return folder_ / name; }

  void Start() {
    std::ofstream(Path("config")) << "sites: {yard: {retention: {quota_bytes: 123456}}}\n";
    server_ = std::make_unique<ChildProcess>(
        ISTHMUS_SERVER,
        std::vector<std::string>{"--data", Path("data"), "--listen", "127.0.0.1:0", "--config",
                                 Path("config")},
        Path("stderr"));
  }
  void Serve() {
    Start();
    const std::string ready = "isthmus-server listening on ", line = server_->ReadLine();
    ASSERT_THAT(line, testing::StartsWith(ready)) << server_->Errors();
    stubs_ = std::make_unique<Stubs>(
        grpc::CreateChannel(line.substr(ready.size()), grpc::InsecureChannelCredentials()));
  }
  void Stop() {
    server_->Signal(SIGTERM);
    EXPECT_EQ(server_->Wait(), 0) << server_->Errors();
  }

  static std::unique_ptr<grpc::ClientContext> At(const std::string& site) {
    auto context = NewContext();
    if (!site.empty()) context->AddMetadata("isthmus-site", site);
    return context;
  }
  v1::Session NewSession(const std::string& site, const std::string& robot) {
    v1::CreateSessionRequest request;
    request.set_robot(robot);
    request.set_sensor("vlp16");
    v1::Session session;
    EXPECT_GRPC_OK(stubs_->sessions->CreateSession(At(site).get(), request, &session));
    return session;
  }
  std::vector<std::string> Sessions(const std::string& site) {
    v1::ListSessionsResponse list;
    EXPECT_GRPC_OK(Merged(stubs_->sessions->ListSessions(At(site).get(), {}), &list));
    std::vector<std::string> names;
    for (const v1::Session& session : list.sessions()) names.push_back(session.id());
    return names;
  }
  int64_t SessionsInBackup(const std::string& site) {
    const auto context = At(site);
    const auto reader = stubs_->admin->BackUp(context.get(), {});
    v1::BackUpResponse part, last;
    while (reader->Read(&part)) last = part;
    EXPECT_GRPC_OK(reader->Finish());
    return last.contents().sessions();
  }
  grpc::Status GetInfo(const std::string& secret) {
    const auto context = NewContext();
    if (!secret.empty()) context->AddMetadata("authorization", "Bearer " + secret);
    v1::MapInfo info;
    return stubs_->map->GetMapInfo(context.get(), {}, &info);
  }

  std::filesystem::path folder_;
  std::unique_ptr<ChildProcess> server_;
  std::unique_ptr<Stubs> stubs_;
};

TEST_F(AccessProcessTest, SitesAreMapsOfTheirOwn) {
  Serve();
  EXPECT_EQ(NewSession("", "alice").quota_bytes(), 0u);
  EXPECT_EQ(NewSession("yard", "alice").quota_bytes(), 123456u);
  NewSession("yard", "bob");
  for (int start = 0; start < 2; ++start) {
    EXPECT_THAT(Sessions(""), testing::ElementsAre("alice-1"));
    EXPECT_THAT(Sessions("default"), testing::ElementsAre("alice-1"));
    EXPECT_THAT(Sessions("yard"), testing::ElementsAre("alice-1", "bob-1"));
    EXPECT_EQ(SessionsInBackup(""), 1);
    EXPECT_EQ(SessionsInBackup("yard"), 2);
    Stop();
    Serve();
  }
  v1::DeleteSessionRequest gone;
  gone.set_session("alice-1");
  v1::DeleteSessionResponse response;
  EXPECT_GRPC_OK(stubs_->edits->DeleteSession(At("yard").get(), gone, &response));
  EXPECT_THAT(Sessions(""), testing::ElementsAre("alice-1"));
  EXPECT_THAT(Sessions("yard"), testing::ElementsAre("bob-1"));
  v1::MapInfo info;
  EXPECT_GRPC_ERROR(stubs_->map->GetMapInfo(At("nowhere").get(), {}, &info), NOT_FOUND, "sites");
  EXPECT_TRUE(std::filesystem::exists(Path("data/sites/yard/isthmus.db")));
}

TEST_F(AccessProcessTest, TokensOfTheFolderCountAtOnceAndDamagedOnesLetNobodyIn) {
  Serve();
  EXPECT_GRPC_OK(GetInfo(""));
  const auto tokens = access::Tokens::Open(Path("data"));
  ASSERT_TRUE(tokens.ok()) << tokens.status();
  const auto made = (*tokens)->Create({"chief", AccessRole::kAdmin, {}, {"*"}});
  ASSERT_TRUE(made.ok()) << made.status();
  while (GetInfo("").ok()) {  // For a second at most.
  }
  EXPECT_GRPC_ERROR(GetInfo(""), UNAUTHENTICATED, "token");
  EXPECT_GRPC_OK(GetInfo(made->secret));
  ASSERT_TRUE((*tokens)->Revoke("chief").ok());
  while (GetInfo(made->secret).ok()) {
  }
  EXPECT_GRPC_ERROR(GetInfo(made->secret), UNAUTHENTICATED, "revoked");
  Stop();
  EXPECT_THAT(server_->Errors(), HasSubstr("there is no token yet"));
  Serve();
  EXPECT_GRPC_ERROR(GetInfo(""), UNAUTHENTICATED, "token");
  Stop();
  std::string text = *io::ReadFile(Path("data/tokens"));
  text[text.size() / 2] ^= 1;
  ASSERT_TRUE(io::WriteFile(Path("data/tokens"), text).ok());
  Start();
  EXPECT_EQ(server_->Wait(), 3);
  EXPECT_THAT(server_->Errors(), HasSubstr("isthmus token create --data"));
}

}  // namespace
}  // namespace isthmus
