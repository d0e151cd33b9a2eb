// A robot that may be switched off at any time: its scans are kept on its own disk until the server
// has them for good.
//
//   example_05_survive_restarts ADDRESS SPOOL_DIR FILE.bin [FILE.bin ...]
//
// Kill it, pull the cable, stop the server; then run the same command again: it goes on behind the
// newest scan that it had pushed, in the same session and the same map.
#include <isthmus/client/client.h>
#include <isthmus/core/formats/kitti_bin.h>

#include <cstdio>
#include <string>

namespace {

absl::Status Drive(const std::string& address, const std::string& spool, int files, char** names) {
  using namespace isthmus;
  using namespace isthmus::client;
  ClientOptions options;
  options.address = address;
  options.require_server = false;  // The robot starts without one, too.
  const auto client = Client::Connect(options);
  if (!client.ok()) return client.status();

  ScanStreamOptions stream_options;
  stream_options.resolution_m = 0.002;
  stream_options.spool_dir = spool;
  stream_options.spool.max_bytes = uint64_t{20} << 30;  // A day at 10 scans a second.
  stream_options.spool.backfill_bytes_per_s = 500'000;  // After an outage.
  stream_options.spool.prefer_live_after_s = 10;        // New scans do not wait for that.
  stream_options.spool.is_replayed = true;              // Files; a real robot leaves it out.
  stream_options.on_event = [](const std::string& event) { std::puts(event.c_str()); };
  const auto stream = (*client)->OpenSpool({RobotId("bob"), "hdl64"}, stream_options);
  if (!stream.ok()) return stream.status();

  // A real robot has its sensor's clock; here the stamps tell which files were pushed before.
  const int64_t pushed_ns = (*stream)->resumed().last_stamp_ns;
  for (int i = 1; i <= files; ++i) {
    const int64_t stamp_ns = i * 100'000'000LL;
    if (stamp_ns <= pushed_ns) continue;
    auto scan = isthmus::formats::ReadKittiBin(names[i - 1]);
    if (!scan.ok()) return scan.status();
    const absl::Status pushed = (*stream)->Push(stamp_ns, *std::move(scan));
    if (!pushed.ok()) return pushed;  // Once OK, the scan outlives this program.
  }
  const auto session = (*stream)->FinishSession();  // All is durable; the spool is empty.
  if (!session.ok()) return session.status();
  std::printf("%s: durable up to scan %zu\n", session->record.id.value().c_str(),
              static_cast<size_t>(session->durable_sequence));
  return absl::OkStatus();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: %s ADDRESS SPOOL_DIR FILE.bin [FILE.bin ...]\n", argv[0]);
    return 2;
  }
  const absl::Status status = Drive(argv[1], argv[2], argc - 3, argv + 3);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
