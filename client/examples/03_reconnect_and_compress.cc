// A robot on a bad radio link: compressed scans, patience, and a window of its own.
//
//   example_03_reconnect_and_compress ADDRESS FILE.bin [FILE.bin ...]
//
// Stop the server while this runs and start it again: nothing is lost, nothing counts twice.
#include <isthmus/client/client.h>
#include <isthmus/core/formats/kitti_bin.h>

#include <cstdio>
#include <string>

namespace {

absl::Status Drive(int files, char** names, const std::string& address) {
  using namespace isthmus;
  using namespace isthmus::client;
  ClientOptions options;
  options.address = address;
  options.backoff.max_attempts = 100;  // Some eight minutes without any sign of the server.
  options.backoff.max_delay_s = 5;
  const auto client = Client::Connect(options);
  if (!client.ok()) return client.status();
  const auto session = (*client)->CreateSession("bob", "hdl64");
  if (!session.ok()) return session.status();

  ScanStreamOptions stream_options;
  stream_options.resolution_m = 0.002;    // About a quarter of the bytes.
  stream_options.window = 50;             // Five seconds may be under way.
  stream_options.spool_bytes = 1u << 30;  // Kept until durable, for a server that crashes.
  const auto stream = (*client)->OpenScanStream(session->record.id, stream_options);
  if (!stream.ok()) return stream.status();
  for (int i = 0; i < files; ++i) {
    auto scan = isthmus::formats::ReadKittiBin(names[i]);
    if (!scan.ok()) return scan.status();
    const absl::Status pushed = (*stream)->Push(i * 100'000'000LL, *std::move(scan));
    if (!pushed.ok()) return pushed;
  }
  const absl::Status finished = (*stream)->Finish();
  const ScanStreamStats stats = (*stream)->stats();
  std::printf("%zu processed, %zu rejected, %zu sent twice, %d reconnects, %.1f MB\n",
              static_cast<size_t>(stats.processed), static_cast<size_t>(stats.rejected),
              static_cast<size_t>(stats.duplicates), stats.reconnects,
              static_cast<double>(stats.sent_bytes) / 1e6);
  return finished;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: %s ADDRESS FILE.bin [FILE.bin ...]\n", argv[0]);
    return 2;
  }
  const absl::Status status = Drive(argc - 2, argv + 2, argv[1]);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
