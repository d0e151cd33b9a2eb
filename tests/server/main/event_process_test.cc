// isthmus-server as a process: its event log and its log, whatever ends it.
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/server/main/child_process.h"
#include "tests/server/rpc/stubs.h"

namespace isthmus {
namespace {

using rpc::Merged;
using rpc::NewContext;
using rpc::Stubs;
using testing::HasSubstr;
using testing::Not;

class EventProcessTest : public testing::Test {
 protected:
  EventProcessTest() {
    std::string pattern = testing::TempDir() + "isthmus-events-XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
    folder_ = pattern;
  }
  ~EventProcessTest() override {
    server_.reset();
    std::filesystem::remove_all(folder_);
  }

  std::string Path(const std::string& name) const { return folder_ / name; }
  std::string Read(const std::string& name) const {
    std::stringstream text;
    text << std::ifstream(Path(name)).rdbuf();
    return text.str();
  }
  void Serve(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"--data", Path("data"), "--listen", "127.0.0.1:0"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    server_ = std::make_unique<ChildProcess>(ISTHMUS_SERVER, arguments, Path("stderr"));
    const std::string ready = "isthmus-server listening on ", line = server_->ReadLine();
    ASSERT_THAT(line, testing::StartsWith(ready)) << server_->Errors();
    stubs_ = std::make_unique<Stubs>(
        grpc::CreateChannel(line.substr(ready.size()), grpc::InsecureChannelCredentials()));
  }
  void Stop() {
    server_->Signal(SIGTERM);
    EXPECT_EQ(server_->Wait(), 0) << server_->Errors();
  }
  std::vector<v1::Event> Events(v1::EventKind kind) {
    v1::ListEventsRequest request;
    request.add_kinds(kind);
    v1::ListEventsResponse list;
    EXPECT_GRPC_OK(Merged(stubs_->events->ListEvents(NewContext().get(), request), &list));
    return {list.events().begin(), list.events().end()};
  }
  void SetDatum(double latitude_deg, const std::string& request_id) {
    const auto context = NewContext();
    context->AddMetadata("x-request-id", request_id);
    v1::SetDatumRequest request;
    request.mutable_datum()->set_latitude_deg(latitude_deg);
    v1::SetDatumResponse response;
    EXPECT_GRPC_OK(stubs_->edits->SetDatum(context.get(), request, &response));
  }

  std::filesystem::path folder_;
  std::unique_ptr<ChildProcess> server_;
  std::unique_ptr<Stubs> stubs_;
};

TEST_F(EventProcessTest, ADecisionThatWasAnsweredHasItsEventAfterAKill) {
  Serve();
  SetDatum(47, "before-the-kill");
  server_->Signal(SIGKILL);
  server_->Wait();
  Serve();
  const std::vector<v1::Event> events = Events(v1::DATUM_SET);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].request_id(), "before-the-kill");
  EXPECT_THAT(events[0].from(), HasSubstr("127.0.0.1"));
  EXPECT_THAT(events[0].text(), HasSubstr("47"));
  Stop();
  Serve();
  ASSERT_EQ(Events(v1::SERVER_STOPPED).size(), 1u);
  EXPECT_THAT(Events(v1::SERVER_STOPPED)[0].text(), HasSubstr("SIGTERM"));
  const uint64_t stop = Events(v1::SERVER_STOPPED)[0].number();
  std::vector<v1::Event> starts = Events(v1::SERVER_STARTED);
  while (starts.back().number() < stop) starts = Events(v1::SERVER_STARTED);  // Soon.
  EXPECT_THAT(starts.back().text(), Not(HasSubstr("did not stop in order")));
  Stop();
}

TEST_F(EventProcessTest, LinesOfCallsSayWhoMadeThem) {
  Serve();
  SetDatum(47, "deploy-12");
  v1::GetSessionRequest request;
  request.set_session("nobody-1\nforged line");
  v1::Session session;
  const auto context = NewContext();
  context->AddMetadata("x-request-id", "deploy-13");
  EXPECT_FALSE(stubs_->sessions->GetSession(context.get(), request, &session).ok());
  Stop();
  const std::string log = server_->Errors();
  EXPECT_THAT(log, testing::ContainsRegex("datum set to .*\\(request deploy-12, peer ipv4:127"));
  EXPECT_THAT(log, testing::ContainsRegex("GetSession: NOT_FOUND: .*\\(request deploy-13, peer"));
  EXPECT_THAT(log, Not(HasSubstr("\nforged")));
}

TEST_F(EventProcessTest, AFileOfObjectsThatIsMovedAwayAndOpenedAnew) {
  Serve({"--log-file", Path("log"), "--log-format", "json"});
  SetDatum(47, "first");
  std::filesystem::rename(Path("log"), Path("log.1"));
  server_->Signal(SIGHUP);
  while (Read("log").find("SIGHUP received") == std::string::npos) {  // In a moment.
  }
  SetDatum(48, "second");
  Stop();
  EXPECT_EQ(server_->Errors(), "");
  const std::string before = Read("log.1"), after = Read("log");
  EXPECT_THAT(before, HasSubstr("\"event\":\"DATUM_SET\",\"request_id\":\"first\""));
  EXPECT_THAT(before, Not(HasSubstr("second")));
  EXPECT_THAT(after, HasSubstr("\"request_id\":\"second\""));
  EXPECT_THAT(after, HasSubstr("SIGHUP received"));
  std::istringstream lines(before + after);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_THAT(line,
                testing::MatchesRegex(
                    "\\{\"time\":\"[0-9-]+T[0-9:.]+Z\",\"level\":\"[a-z]+\",\"message\":.*\\}"));
  }
}

TEST_F(EventProcessTest, ALogFileThatCannotBeOpenedIsAnError) {
  ChildProcess server(ISTHMUS_SERVER,
                      {"--data", Path("data"), "--log-file", Path("no/such/folder/log")},
                      Path("stderr"));
  EXPECT_EQ(server.Wait(), 2);
  EXPECT_THAT(server.Errors(), HasSubstr("no/such/folder/log"));
}

}  // namespace
}  // namespace isthmus
