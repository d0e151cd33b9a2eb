// isthmus-server as a process: its output, its end, and acknowledged scans that are there when it
// comes back.
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/server/main/child_process.h"
#include "tests/server/rpc/room_scans.h"
#include "tests/server/rpc/stubs.h"

namespace isthmus {
namespace {

using rpc::NewContext;
using rpc::Stubs;
using testing::HasSubstr;
using Response = v1::StreamScansResponse;

const char kReady[] = "isthmus-server listening on ";

class ServerProcessTest : public testing::Test {
 protected:
  ServerProcessTest() {
    std::string pattern = testing::TempDir() + "isthmus-server-XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
    folder_ = pattern;
  }
  ~ServerProcessTest() override {
    server_.reset();
    std::filesystem::remove_all(folder_);
  }

  std::string Path(const std::string& name) const { return folder_ / name; }

  void Start(const std::vector<std::string>& arguments) {
    server_ = std::make_unique<ChildProcess>(ISTHMUS_SERVER, arguments, Path("stderr"));
  }
  // Returns the exit code; the program must end by itself.
  int Run(const std::vector<std::string>& arguments) {
    Start(arguments);
    return server_->Wait();
  }
  // Starts it on the test's data folder and waits until it listens.
  void Serve() {
    Start({"--data", Path("data"), "--listen", "127.0.0.1:0"});
    const std::string line = server_->ReadLine();
    ASSERT_THAT(line, testing::StartsWith(kReady)) << server_->Errors();
    address_ = line.substr(sizeof(kReady) - 1);
    stubs_ =
        std::make_unique<Stubs>(grpc::CreateChannel(address_, grpc::InsecureChannelCredentials()));
  }
  v1::Session Get(const std::string& session) {
    v1::GetSessionRequest request;
    request.set_session(session);
    v1::Session response;
    EXPECT_GRPC_OK(stubs_->sessions->GetSession(NewContext().get(), request, &response));
    return response;
  }
  // Streams scans until the server ends the stream, which `at` brings about: it is called with the
  // first acknowledgement of that sequence. Returns the last acknowledgement.
  Response StreamUntilCut(const std::string& session,
                          const std::function<bool(const Response& ack)>& is_time,
                          const std::function<void()>& cut) {
    const auto context = NewContext();
    auto wire = stubs_->sessions->StreamScans(context.get());
    std::thread writer([&] {
      for (uint64_t i = 1; wire->Write(rpc::RoomScan(session, i)); ++i) {
      }
    });
    Response ack, last;
    bool is_cut = false;
    while (wire->Read(&ack)) {
      if (!is_cut && is_time(ack)) {
        is_cut = true;
        cut();
      }
      if (ack.sequence() == 0) {
        last.set_durable_sequence(ack.durable_sequence());
        continue;
      }
      EXPECT_EQ(ack.outcome(), Response::PROCESSED) << ack.reason();
      last = ack;
    }
    writer.join();
    wire->Finish();
    return last;
  }

  std::filesystem::path folder_;
  std::unique_ptr<ChildProcess> server_;
  std::string address_;
  std::unique_ptr<Stubs> stubs_;
};

TEST_F(ServerProcessTest, WhatWasAcknowledgedBeforeSigtermIsThereAfterRestart) {
  Serve();
  const std::string session = stubs_->NewSession("alice");
  const auto at_twelve = [](const Response& ack) { return ack.sequence() == 12; };
  const Response last = StreamUntilCut(session, at_twelve, [this] { server_->Signal(SIGTERM); });
  EXPECT_EQ(server_->Wait(), 0) << server_->Errors();
  EXPECT_GE(last.sequence(), 12u);

  Serve();
  const v1::Session resumed = Get(session);
  EXPECT_EQ(resumed.state(), v1::Session::ACTIVE);
  EXPECT_GE(resumed.last_sequence(), last.sequence());
  EXPECT_EQ(resumed.durable_sequence(), resumed.last_sequence());
  // And the session goes on where it was.
  const auto context = NewContext();
  auto wire = stubs_->sessions->StreamScans(context.get());
  wire->Write(rpc::RoomScan(session, last.sequence()));
  wire->Write(rpc::RoomScan(session, resumed.last_sequence() + 1));
  wire->WritesDone();
  Response ack;
  ASSERT_TRUE(wire->Read(&ack));
  EXPECT_EQ(ack.outcome(), Response::DUPLICATE);
  ASSERT_TRUE(wire->Read(&ack));
  EXPECT_EQ(ack.outcome(), Response::PROCESSED) << ack.reason();
  while (wire->Read(&ack)) {
  }
  EXPECT_GRPC_OK(wire->Finish());
}

TEST_F(ServerProcessTest, WhatWasDurableSurvivesAKill) {
  Serve();
  const std::string session = stubs_->NewSession("alice");
  const auto once_durable = [](const Response& ack) { return ack.durable_sequence() > 0; };
  const Response last = StreamUntilCut(session, once_durable, [this] { server_->Signal(SIGKILL); });
  EXPECT_EQ(server_->Wait(), 128 + SIGKILL);
  EXPECT_GT(last.durable_sequence(), 0u);

  Serve();
  const v1::Session resumed = Get(session);
  EXPECT_GE(resumed.durable_sequence(), last.durable_sequence());
  EXPECT_GE(resumed.submap_count(), 1u);
}

TEST_F(ServerProcessTest, AnIdleServerStopsAtOnceOnSigint) {
  Serve();
  server_->Signal(SIGINT);
  EXPECT_EQ(server_->Wait(), 0);
  EXPECT_THAT(server_->Errors(), HasSubstr("SIGINT received"));
}

// As the whole program sets it up: a server that was told nothing runs odometry on one thread
// otherwise, and every robot waits for every other.
TEST_F(ServerProcessTest, ByDefaultSeveralThreadsTakeScansIn) {
  Serve();
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  int threads = 0;  // A thread says its name once it runs.
  while (threads < 4 && std::chrono::steady_clock::now() < deadline) {
    threads = 0;
    const std::string tasks = "/proc/" + std::to_string(server_->pid()) + "/task";
    for (const auto& task : std::filesystem::directory_iterator(tasks)) {
      std::string name;
      std::ifstream(task.path() / "comm") >> name;
      threads += name == "ingest" ? 1 : 0;
    }
  }
  EXPECT_GE(threads, 4);
}

TEST_F(ServerProcessTest, SighupEndsNothingAndSaysWhatToDo) {
  Serve();
  const std::string session = stubs_->NewSession("alice");
  server_->Signal(SIGHUP);
  EXPECT_EQ(Get(session).state(), v1::Session::ACTIVE);
  server_->Signal(SIGTERM);
  EXPECT_EQ(server_->Wait(), 0);
  EXPECT_THAT(server_->Errors(), HasSubstr("SIGHUP received and ignored"));
}

// While it waits for its settings, which come out of a pipe.
TEST_F(ServerProcessTest, ASignalBeforeItHasSaidAnythingEndsItInGoodOrder) {
  ASSERT_EQ(mkfifo(Path("config").c_str(), 0600), 0);
  Start({"--data", Path("data"), "--listen", "127.0.0.1:0", "--config", Path("config")});
  std::ofstream config(Path("config"));  // Waits until the server reads.
  server_->Signal(SIGTERM);
  config << "ingest: {threads: 1}\n";
  config.close();
  EXPECT_THAT(server_->ReadLine(), testing::StartsWith(kReady));
  EXPECT_EQ(server_->Wait(), 0) << server_->Errors();
}

TEST_F(ServerProcessTest, APortThatThereIsNotIsRefusedBeforeTheFolderIsMade) {
  EXPECT_EQ(Run({"--data", Path("data"), "--listen", "127.0.0.1:70000"}), 2);
  EXPECT_THAT(server_->Errors(), HasSubstr("ports are 0 to 65535"));
  EXPECT_FALSE(std::filesystem::exists(Path("data")));
}

TEST_F(ServerProcessTest, UsageErrors) {
  EXPECT_EQ(Run({}), 2);
  EXPECT_THAT(server_->Errors(), HasSubstr("--data"));
  EXPECT_EQ(Run({"--dat", "x"}), 2);
  EXPECT_EQ(Run({"--data", Path("data"), "--log-level", "loud"}), 2);
  EXPECT_EQ(Run({"--data", Path("data"), "--config", Path("none.yaml")}), 2);
  EXPECT_THAT(server_->Errors(), HasSubstr("none.yaml"));
  std::ofstream(Path("bad.yaml")) << "ingest:\n  scan_quue: 3\n";
  EXPECT_EQ(Run({"--data", Path("data"), "--config", Path("bad.yaml")}), 2);
  EXPECT_THAT(server_->Errors(), HasSubstr("ingest.scan_quue"));
  // A shell leaves that of a variable that is not set.
  for (const char* option : {"--config", "--store", "--listen", "--web", "--log-file", "--check"}) {
    EXPECT_EQ(Run({option, "", "--data", Path("data"), "--print-config"}), 2) << option;
    EXPECT_THAT(server_->Errors(), HasSubstr(std::string(option) + " has no value"));
  }
  EXPECT_EQ(Run({"--data", "\xff"}), 2);
  EXPECT_THAT(server_->Errors(), HasSubstr("UTF-8"));
  EXPECT_FALSE(std::filesystem::exists(Path("data")));
}

TEST_F(ServerProcessTest, ADataFolderThatCannotBeUsed) {
  std::ofstream(Path("file")) << "x";
  EXPECT_EQ(Run({"--data", Path("file")}), 3);
  EXPECT_THAT(server_->Errors(), HasSubstr(Path("file")));
  std::filesystem::create_directory(Path("data"));
  std::ofstream(Path("data/isthmus.db")) << "this is not a database, but long enough to be read";
  EXPECT_EQ(Run({"--data", Path("data"), "--listen", "127.0.0.1:0"}), 3);
}

TEST_F(ServerProcessTest, AMapThatIsInADatabaseIsNotBegunAnew) {
  std::filesystem::create_directory(Path("data"));
  std::ofstream(Path("data/map-is-elsewhere")) << "postgresql://db/isthmus\n";
  EXPECT_EQ(Run({"--data", Path("data"), "--listen", "127.0.0.1:0"}), 3);
  EXPECT_THAT(server_->Errors(),
              HasSubstr("is kept in postgresql://db/isthmus: start with --store"));
  EXPECT_FALSE(std::filesystem::exists(Path("data/isthmus.db")));
}

TEST_F(ServerProcessTest, ASecondServerFindsFolderAndPortTaken) {
  Serve();
  ChildProcess same_folder(ISTHMUS_SERVER, {"--data", Path("data"), "--listen", "127.0.0.1:0"},
                           Path("stderr2"));
  EXPECT_EQ(same_folder.Wait(), 3);
  EXPECT_NE(same_folder.Errors(), "");
  ChildProcess same_port(ISTHMUS_SERVER, {"--data", Path("data2"), "--listen", address_},
                         Path("stderr3"));
  EXPECT_EQ(same_port.Wait(), 4);
  EXPECT_THAT(same_port.Errors(), HasSubstr(address_));
}

TEST_F(ServerProcessTest, CheckSaysSoundDamagedOrUnreadable) {
  EXPECT_EQ(Run({"--check"}), 2);
  EXPECT_EQ(Run({"--data", Path("data"), "--check"}), 2);
  EXPECT_THAT(server_->Errors(), HasSubstr("there is no map"));
  EXPECT_FALSE(std::filesystem::exists(Path("data")));
  Serve();
  ChildProcess beside(ISTHMUS_SERVER, {"--data", Path("data"), "--check"}, Path("beside"));
  EXPECT_EQ(beside.Wait(), 2);
  EXPECT_THAT(beside.Errors(), HasSubstr("is in use by process"));
  server_->Signal(SIGTERM);
  EXPECT_EQ(server_->Wait(), 0);
  Start({"--data", Path("data"), "--check"});
  EXPECT_THAT(server_->ReadAll(), HasSubstr("\nsound\n"));
  EXPECT_EQ(server_->Wait(), 0);
  Start({"--check", Path("data")});
  EXPECT_THAT(server_->ReadAll(), HasSubstr("\nsound\n"));
  EXPECT_EQ(server_->Wait(), 0);
  EXPECT_EQ(Run({"--check", Path("data"), "--data", Path("other")}), 2);
  std::filesystem::resize_file(Path("data/isthmus.db"), 3 * 4096);
  Start({"--data", Path("data"), "--check"});
  EXPECT_THAT(server_->ReadAll(), HasSubstr("DAMAGED"));
  EXPECT_EQ(server_->Wait(), 1);
}

// A map that got lost would else be served as an empty one.
TEST_F(ServerProcessTest, AFolderThatLostItsDatabaseIsRefused) {
  std::filesystem::create_directories(Path("data/scans/alice-1"));
  const auto expect_refusal = [this](const std::string& left) {
    EXPECT_EQ(Run({"--data", Path("data"), "--listen", "127.0.0.1:0"}), 3);
    EXPECT_THAT(server_->Errors(), testing::AllOf(HasSubstr("isthmus.db is missing or empty"),
                                                  HasSubstr("restore a backup, or move " + left)));
  };
  expect_refusal(Path("data/scans"));
  std::filesystem::remove_all(Path("data/scans"));
  for (const char* name : {"data/composed.points", "data/composed.index"}) {
    std::ofstream(Path(name)) << "points";
    for (const bool is_empty : {false, true}) {
      if (is_empty) std::ofstream file(Path("data/isthmus.db"));
      expect_refusal(Path(name));
      EXPECT_EQ(Run({"--check", Path("data")}), 2) << "It is not sound.";
      EXPECT_EQ(std::filesystem::exists(Path("data/isthmus.db")), is_empty);
      std::filesystem::remove(Path("data/isthmus.db"));
    }
    std::filesystem::remove(Path(name));
  }
  Serve();
}

TEST_F(ServerProcessTest, PrintConfigAndVersion) {
  Start({"--version"});
  EXPECT_THAT(server_->ReadLine(), testing::StartsWith("isthmus-server "));
  EXPECT_EQ(server_->Wait(), 0);
  std::ofstream(Path("some.yaml")) << "ingest:\n  threads: 7\nrevisits: {grace_h: 3}\n";
  Start({"--print-config", "--config", Path("some.yaml"), "--listen", "127.0.0.1:9"});
  const std::string text = server_->ReadAll();
  EXPECT_EQ(server_->Wait(), 0);
  EXPECT_THAT(text, HasSubstr("listen: \"127.0.0.1:9\""));
  EXPECT_THAT(text, HasSubstr("threads: 7"));
  EXPECT_THAT(server_->Errors(), HasSubstr("revisits.grace_h is no longer a setting"));
}

}  // namespace
}  // namespace isthmus
