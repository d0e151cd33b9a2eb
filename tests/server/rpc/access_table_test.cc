// Every method of every service, called with every role: the table of roles and methods.
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_replace.h>
#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <optional>
#include <set>

#include "server/access/methods.h"
#include "tests/server/rpc/fake_pipeline.h"
#include "tests/server/rpc/generic_call.h"

namespace isthmus::rpc {
namespace {

using google::protobuf::DescriptorPool;
using google::protobuf::MethodDescriptor;
using grpc::StatusCode;

// The API's promise for a method. In requests ROBOT stands for a robot's name, SESSION for its
// session's.
struct Row {
  std::string roles;  // The initials of those that may call it: Robot, reader (v), operator, admin.
  std::string request;  // In protobuf's text form.
  // The code for a robot that asks for something of another's, or of one that is not there; only
  // for methods that a robot may call.
  StatusCode others = StatusCode::OK;
};

// Beginnings of the names of methods that change nothing.
constexpr const char* kReading[] = {"Get",   "List", "Query",    "Export", "Find",
                                    "Watch", "Diff", "Localise", "BackUp", "ServerReflectionInfo"};

const std::map<std::string, Row>& Table() {
  static const auto* const table = new std::map<std::string, Row>{
      {"SessionService/CreateSession",
       {"Ra", "robot: 'ROBOT' sensor: 'vlp16'", StatusCode::PERMISSION_DENIED}},
      {"SessionService/GetSession", {"Rvoa", "session: 'SESSION'", StatusCode::NOT_FOUND}},
      {"SessionService/ListSessions", {"Rvoa", "", StatusCode::OK}},
      {"SessionService/FinishSession", {"Roa", "session: 'SESSION'", StatusCode::NOT_FOUND}},
      {"SessionService/StreamScans", {"Ra", "session: 'SESSION'", StatusCode::NOT_FOUND}},
      {"SessionService/UploadSubmap",
       {"Ra", "header { session: 'SESSION' size: 9 }", StatusCode::NOT_FOUND}},
      {"SessionService/GetUpload", {"Ra", "session: 'SESSION'", StatusCode::NOT_FOUND}},
      {"LocalisationService/Localise",
       {"Ra", "begin { sensor: 'vlp16' in_map_of: 'ROBOT' }", StatusCode::PERMISSION_DENIED}},
      {"MapService/GetMapInfo", {"voa", ""}},
      {"MapService/ListSubmaps", {"voa", "robot: 'ROBOT'"}},
      {"MapService/GetTrajectory", {"voa", "robot: 'ROBOT' frame: MAP"}},
      {"MapService/GetMatchGraph", {"voa", ""}},
      {"MapService/ListLoops", {"voa", "robot: 'ROBOT'"}},
      {"MapService/ListAnchors", {"voa", ""}},
      {"MapService/ListRevisions", {"voa", "limit: 3"}},
      {"MapService/DiffRevisions", {"voa", "from_revision: 1 to_revision: 2"}},
      {"MapService/GetTransform", {"voa", "robot_a: 'ROBOT' robot_b: 'bob'"}},
      {"MapService/QueryRegion", {"voa", "robot: 'ROBOT'"}},
      {"MapService/ExportMap", {"voa", "format: PLY"}},
      {"MapService/ExportPoseGraph", {"voa", ""}},
      {"MapService/FindChanges", {"voa", "since_revision: 1"}},
      {"MapService/ListTiles", {"voa", ""}},
      {"MapService/GetTile", {"voa", "id { x: 1 }"}},
      {"MapService/WatchMap", {"voa", "level: 99"}},  // It ends, as no map has so many.
      {"EditService/DecideMatch", {"oa", "robot_a: 'ROBOT' robot_b: 'bob' decision: REJECT"}},
      {"EditService/DecideLoop", {"oa", "id: 3 decision: REJECT"}},
      {"EditService/PutAnchor",
       {"oa",
        "anchor { session: 'SESSION' t_map_submap { translation { x: 1 } rotation { w: 1 } } "
        "sigma_xy_m: 1 }"}},
      {"EditService/DeleteAnchor", {"oa", "session: 'SESSION'"}},
      {"EditService/SetDatum", {"oa", "datum { latitude_deg: 47 longitude_deg: 8 }"}},
      {"EditService/UndoRevision", {"oa", "revision: 3"}},
      {"EditService/DeleteSession", {"oa", "session: 'SESSION'"}},
      {"EventService/ListEvents", {"oa", "after: 0"}},
      {"EventService/WatchEvents", {"oa", "after: 99"}},  // It ends, as there are none.
      {"AdminService/BackUp", {"a", ""}},
      {"AdminService/GetStatus", {"voa", ""}},
      {"AccessService/GetOwnToken", {"Rvoa", "", StatusCode::OK}},
      {"AccessService/CreateToken", {"a", "token { name: 'fresh' role: ROLE_READER }"}},
      {"AccessService/ListTokens", {"a", ""}},
      {"AccessService/RevokeToken", {"a", "name: 'nobody'"}},
  };
  return *table;
}

// The methods in all .proto files of the API, linked or not.
std::vector<const MethodDescriptor*> AllMethods() {
  std::vector<const MethodDescriptor*> methods;
  for (const auto& entry : std::filesystem::directory_iterator(ISTHMUS_API_FOLDER "/isthmus/v1")) {
    const std::string name = "isthmus/v1/" + entry.path().filename().string();
    const auto* file = DescriptorPool::generated_pool()->FindFileByName(name);
    if (file == nullptr) {
      ADD_FAILURE() << name << " is not part of this test: include it in stubs.h";
      continue;
    }
    for (int s = 0; s < file->service_count(); ++s) {
      for (int m = 0; m < file->service(s)->method_count(); ++m) {
        methods.push_back(file->service(s)->method(m));
      }
    }
  }
  return methods;
}

std::string NameOf(const MethodDescriptor& method) {
  return method.service()->name() + "/" + method.name();
}

// The effect of the calls so far on a pipeline.
std::string Touched(FakePipeline& p) {
  std::string sessions;
  for (const SessionStatus& session : p.sessions().List()) {
    absl::StrAppend(&sessions, session.record.id.value(), static_cast<int>(session.record.state));
  }
  return absl::StrCat(sessions, " ", p.match_decisions.size(), " ", p.loop_decisions.size(), " ",
                      p.anchors.size(), " ", p.unanchored.size(), " ", p.undone.size(), " ",
                      p.exports.size(), " ", p.submitted(), " ", p.submaps().size(), " ",
                      p.asked_limit, " ", p.asked_diff.second, " ", p.trajectory_segment, " ",
                      p.asked_robot ? p.asked_robot->value() : "", " ", p.info.datum.has_value());
}

struct Answer {
  grpc::Status status;
  std::string responses;
};

// A server of two sites, with robots of the same names in both, and "vault" in the yard alone.
class AccessTableTest : public testing::Test {
 protected:
  AccessTableTest() {
    std::string pattern = testing::TempDir() + "isthmus-access-XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
    folder_ = pattern;
    tokens_ = *access::Tokens::Open(folder_, nullptr, clock_);
    for (FakePipeline* pipeline : {&default_, &yard_}) {
      for (const char* robot : {"alice", "bob"}) {
        (void)pipeline->sessions().Create({.robot = RobotId(robot), .sensor = "vlp16"});
        pipeline->info.robots.push_back(RobotId(robot));
      }
    }
    (void)yard_.sessions().Create({.robot = RobotId("vault"), .sensor = "vlp16"});
    yard_.info.robots.push_back(RobotId("vault"));
    ServerOptions options;
    options.listen = "127.0.0.1:0";
    options.tokens = tokens_.get();
    server_ = *RpcServer::Start(
        {{.name = "default", .pipeline = &default_}, {.name = "yard", .pipeline = &yard_}},
        options);
    channel_ = grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials());
    Make("R", AccessRole::kRobot, {"default"});
    Make("v", AccessRole::kReader, {"default"});
    Make("o", AccessRole::kOperator, {"default"});
    Make("a", AccessRole::kAdmin, {"*"});
  }
  ~AccessTableTest() override { std::filesystem::remove_all(folder_); }

  // A token with the secret of that key; a robot's is alice's.
  void Make(const std::string& key, AccessRole role, const std::vector<std::string>& sites,
            int64_t expires_ns = 0) {
    AccessToken token{"key-" + key, role, {}, sites, 0, expires_ns, 0};
    if (role == AccessRole::kRobot) token.robots = {"alice"};
    const auto made = tokens_->Create(token);
    ASSERT_TRUE(made.ok()) << made.status();
    secrets_[key] = made->secret;
  }
  static AccessRole RoleOf(char initial) {
    switch (initial) {
      case 'R':
        return AccessRole::kRobot;
      case 'v':
        return AccessRole::kReader;
      case 'o':
        return AccessRole::kOperator;
      default:
        return AccessRole::kAdmin;
    }
  }
  Headers As(const std::string& key, const std::string& site = "") const {
    Headers headers = {{"authorization", "Bearer " + secrets_.at(key)}};
    if (!site.empty()) headers.emplace_back("isthmus-site", site);
    return headers;
  }
  // Asks for something of that robot; its session is its name with "-1" behind it, or -2.
  Answer Ask(const MethodDescriptor& method, const Headers& headers,
             const std::string& robot = "alice") {
    const std::string session = robot == "alice" ? "alice-1" : robot + "-2";
    const std::string text = absl::StrReplaceAll(Table().at(NameOf(method)).request,
                                                 {{"ROBOT", robot}, {"SESSION", session}});
    Answer answer;
    answer.status =
        GenericCall(channel_, absl::StrCat("/", method.service()->full_name(), "/", method.name()),
                    headers, ToBytes(method.input_type(), text), &answer.responses);
    return answer;
  }
  // Expects the code, and no name of a robot, site, session or token.
  static void ExpectRefused(const Answer& answer, StatusCode code) {
    EXPECT_EQ(answer.status.error_code(), code) << answer.status.error_message();
    EXPECT_EQ(answer.responses, "");
    const std::string& message = answer.status.error_message();
    EXPECT_FALSE(message.empty());
    for (const char* secret : {"alice", "bob", "vault", "yard", "key-", "isthmus_"}) {
      EXPECT_THAT(message, testing::Not(testing::HasSubstr(secret)));
    }
  }

  ManualClock clock_{1'790'000'000'000'000'000};
  std::string folder_;
  std::unique_ptr<access::Tokens> tokens_;
  FakePipeline default_, yard_;
  std::unique_ptr<RpcServer> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::map<std::string, std::string> secrets_;
};

TEST_F(AccessTableTest, HasARowAndARuleForEveryMethod) {
  std::set<std::string> names, bare;
  for (const MethodDescriptor* method : AllMethods()) {
    names.insert(NameOf(*method));
    EXPECT_TRUE(bare.insert(method->name()).second) << method->name() << " is there twice";
    EXPECT_TRUE(Table().contains(NameOf(*method))) << "add a row for " << NameOf(*method);
    EXPECT_NE(access::FindMethod(method->name()), nullptr) << "add a row for " << NameOf(*method);
  }
  EXPECT_EQ(names.size(), 39u);
  for (const auto& [name, row] : Table()) EXPECT_TRUE(names.contains(name)) << name << " is gone";
}

TEST_F(AccessTableTest, NobodyIsLetInWithoutATokenThatHolds) {
  Make("expired", AccessRole::kAdmin, {"*"}, clock_.NowNs() + 1'000'000'000);
  Make("revoked", AccessRole::kAdmin, {"*"});
  ASSERT_TRUE(tokens_->Revoke("key-revoked").ok());
  clock_.Advance(2'000'000'000);
  const std::string good = secrets_["a"];
  const Headers wrong[] = {
      {},
      {{"authorization", ""}},
      {{"authorization", good}},
      {{"authorization", "Basic " + good}},
      {{"authorization", "Bearer "}},
      {{"authorization", "Bearer " + good + "x"}},
      {{"authorization", "Bearer " + good.substr(0, good.size() - 1)}},
      {{"authorization", "Bearer " + std::string(5000, 'x')}},
      {{"authorization", "Bearer " + good}, {"authorization", "Bearer " + good}},
      {{"isthmus-site", "yard"}},
      As("expired"),
      As("revoked"),
  };
  const std::string before = Touched(default_) + Touched(yard_);
  for (const MethodDescriptor* method : AllMethods()) {
    for (size_t k = 0; k < std::size(wrong); ++k) {
      SCOPED_TRACE(absl::StrCat(NameOf(*method), " with ", k));
      ExpectRefused(Ask(*method, wrong[k]), StatusCode::UNAUTHENTICATED);
    }
  }
  EXPECT_EQ(Touched(default_) + Touched(yard_), before);
}

TEST_F(AccessTableTest, EachRoleMayWhatItsRowSays) {
  for (const MethodDescriptor* method : AllMethods()) {
    for (const char role : std::string("Rvoa")) {
      SCOPED_TRACE(absl::StrCat(NameOf(*method), " by ", std::string(1, role)));
      const Answer answer = Ask(*method, As(std::string(1, role)));
      if (absl::StrContains(Table().at(NameOf(*method)).roles, role)) {
        EXPECT_NE(answer.status.error_code(), StatusCode::UNAUTHENTICATED);
        EXPECT_NE(answer.status.error_code(), StatusCode::PERMISSION_DENIED)
            << answer.status.error_message();
      } else {
        ExpectRefused(answer, StatusCode::PERMISSION_DENIED);
      }
    }
  }
}

// A robot goes on to another address, a person is told.
TEST_F(AccessTableTest, AReplicaRefusesEveryChangeAndAnswersTheRest) {
  default_.takes_changes = absl::FailedPreconditionError("a replica");
  for (const MethodDescriptor* method : AllMethods()) {
    SCOPED_TRACE(NameOf(*method));
    const std::string before = Touched(default_);
    const Answer answer = Ask(*method, As("a"));
    const bool reads = method->name() != "GetUpload" &&
                       std::any_of(std::begin(kReading), std::end(kReading), [&](const char* verb) {
                         return absl::StartsWith(method->name(), verb);
                       });
    EXPECT_EQ(answer.status.error_message() != "a replica", reads);
    if (reads) continue;
    EXPECT_EQ(Touched(default_), before);
    const bool is_robots = absl::StrContains(Table().at(NameOf(*method)).roles, 'R');
    EXPECT_EQ(answer.status.error_code(),
              is_robots ? StatusCode::UNAVAILABLE : StatusCode::FAILED_PRECONDITION);
  }
}

// A robot cannot tell another robot's things from things that are not there.
TEST_F(AccessTableTest, ARobotLearnsNothingOfAnother) {
  const std::string before = Touched(default_);
  for (const MethodDescriptor* method : AllMethods()) {
    const Row& row = Table().at(NameOf(*method));
    if (!absl::StrContains(row.roles, 'R')) continue;
    SCOPED_TRACE(NameOf(*method));
    const Answer others = Ask(*method, As("R"), "bob");
    const Answer nobodys = Ask(*method, As("R"), "zed");
    EXPECT_EQ(others.status.error_code(), row.others) << others.status.error_message();
    EXPECT_EQ(nobodys.status.error_code(), row.others) << nobodys.status.error_message();
    EXPECT_EQ(absl::StrReplaceAll(others.status.error_message(), {{"bob", "zed"}}),
              nobodys.status.error_message());
    EXPECT_EQ(others.responses, nobodys.responses);
    EXPECT_FALSE(absl::StrContains(others.responses, "bob"));
    EXPECT_FALSE(absl::StrContains(others.responses, "vault"));
  }
  EXPECT_EQ(Touched(default_), before);
}

// A site shows only to callers that may see it.
TEST_F(AccessTableTest, OtherSitesAreOutOfReach) {
  for (const MethodDescriptor* method : AllMethods()) {
    const std::string& roles = Table().at(NameOf(*method)).roles;
    const std::string before = Touched(yard_);
    for (const char role : roles) {
      if (role == 'a') continue;  // An administrator's token is for all sites.
      SCOPED_TRACE(absl::StrCat(NameOf(*method), " by ", std::string(1, role)));
      const std::string key(1, role);
      const Answer there = Ask(*method, As(key, "yard"));
      const Answer nowhere = Ask(*method, As(key, "nowhere"));
      ExpectRefused(there, StatusCode::PERMISSION_DENIED);
      ExpectRefused(nowhere, StatusCode::PERMISSION_DENIED);
      EXPECT_EQ(there.status.error_message(), nowhere.status.error_message());
    }
    ExpectRefused(Ask(*method, As("a", "nowhere")), StatusCode::NOT_FOUND);
    EXPECT_EQ(Touched(yard_), before);
  }
}

// With the same names of robots in both.
TEST_F(AccessTableTest, NothingCrossesFromSiteToSite) {
  for (const char role : std::string("Rvo")) {
    Make(std::string(1, role) + "yard", RoleOf(role), {"yard"});
  }
  for (const MethodDescriptor* method : AllMethods()) {
    const Row& row = Table().at(NameOf(*method));
    if (method->service()->name() == "AccessService") continue;  // It is the whole server's.
    SCOPED_TRACE(NameOf(*method));
    const std::string role(1, row.roles[0]);
    const std::string yard_before = Touched(yard_), untouched = Touched(default_);
    const Answer here = Ask(*method, As(role));
    EXPECT_EQ(Touched(yard_), yard_before);
    EXPECT_FALSE(absl::StrContains(here.responses, "vault"));
    const std::string default_before = Touched(default_);
    // An admin's token is for all sites, and must say which; the others' is for one.
    const Answer there = Ask(*method, role == "a" ? As("a", "yard") : As(role + "yard"));
    EXPECT_EQ(Touched(default_), default_before);
    EXPECT_EQ(here.status.error_code(), there.status.error_code());
    EXPECT_EQ(Touched(yard_) != yard_before, default_before != untouched) << "done there, too";
  }
  std::string responses;
  ASSERT_TRUE(
      GenericCall(channel_, "/isthmus.v1.SessionService/ListSessions", As("vyard"), "", &responses)
          .ok());
  EXPECT_TRUE(absl::StrContains(responses, "vault"));
}

}  // namespace
}  // namespace isthmus::rpc
