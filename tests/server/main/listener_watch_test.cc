#include "server/main/listener_watch.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <thread>
#include <utility>

namespace isthmus::server {
namespace {

using std::chrono::milliseconds;

// A listener whose backlog the system fills: it accepts when it is told to only.
class SilentListener {
 public:
  SilentListener() : file_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    bind(file_, reinterpret_cast<sockaddr*>(&address), size);
    listen(file_, 1);
    getsockname(file_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
  }
  ~SilentListener() { Close(); }
  void Close() {
    if (file_ >= 0) close(std::exchange(file_, -1));
  }
  void AcceptAndHangUp() const { close(accept(file_, nullptr, nullptr)); }
  std::string At(const std::string& host) const { return host + ":" + std::to_string(port_); }

 private:
  int file_;
  int port_ = 0;
};

TEST(ProbeListener, KnowsABacklogFromAProgramThatAccepts) {
  SilentListener listener;
  EXPECT_EQ(ProbeListener(listener.At("127.0.0.1"), milliseconds(50)).code(),
            absl::StatusCode::kDeadlineExceeded);
  // The one above still waits in the backlog.
  std::thread program([&] {
    listener.AcceptAndHangUp();
    listener.AcceptAndHangUp();
  });
  const absl::Status status = ProbeListener(listener.At("0.0.0.0"), milliseconds(30'000));
  EXPECT_TRUE(status.ok()) << status;
  program.join();
}

TEST(ProbeListener, SaysWhenNobodyListens) {
  SilentListener listener;
  listener.Close();
  EXPECT_EQ(ProbeListener(listener.At("127.0.0.1"), milliseconds(1000)).code(),
            absl::StatusCode::kUnavailable);
  EXPECT_EQ(ProbeListener("unix:/nonexistent/socket", milliseconds(1000)).code(),
            absl::StatusCode::kUnavailable);
  EXPECT_FALSE(ProbeListener("unix:" + std::string(200, 'x'), milliseconds(1000)).ok());
}

TEST(ProbeListener, KnowsNothingWhereTheAddressIsNotOfThisMachine) {
  // This net is reserved for documentation.
  EXPECT_EQ(ProbeListener("192.0.2.1:50051", milliseconds(1000)).code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST(ProbeListener, ReachesASocketThatIsAFile) {
  std::string folder = testing::TempDir() + "isthmus-probe-XXXXXX";
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  const int file = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  (folder + "/s").copy(address.sun_path, sizeof(address.sun_path) - 1);
  ASSERT_EQ(bind(file, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  ASSERT_EQ(listen(file, 1), 0);
  std::thread program([&] { close(accept(file, nullptr, nullptr)); });
  const absl::Status status = ProbeListener("unix:" + folder + "/s", milliseconds(30'000));
  EXPECT_TRUE(status.ok()) << status;
  program.join();
  close(file);
  std::filesystem::remove_all(folder);
}

TEST(ListenerWatch, TellsOfEachAnswerAndOnceOfASilence) {
  std::string heard;
  absl::Status answer = absl::OkStatus();
  ListenerWatch::Options options;
  options.probe = [&] { return answer; };
  options.on_answer = [&] { heard += "a"; };
  options.on_silence = [&](const absl::Status&) { heard += "s"; };
  ListenerWatch watch(options);
  const auto probe = [&](absl::StatusCode code) {
    answer = absl::Status(code, "");
    watch.Probe();
  };
  for (const auto code : {absl::StatusCode::kOk, absl::StatusCode::kDeadlineExceeded,
                          absl::StatusCode::kDeadlineExceeded, absl::StatusCode::kOk,
                          absl::StatusCode::kDeadlineExceeded}) {
    probe(code);
  }
  EXPECT_EQ(heard, "asas");
  // An address that is away is no silence, nor does it end one.
  probe(absl::StatusCode::kFailedPrecondition);
  probe(absl::StatusCode::kDeadlineExceeded);
  EXPECT_EQ(heard, "asasa");
}

}  // namespace
}  // namespace isthmus::server
