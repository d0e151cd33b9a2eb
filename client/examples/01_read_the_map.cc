// The shortest way to a merged map: connect, export.
//
//   example_01_read_the_map [ADDRESS]
#include <isthmus/client/client.h>

#include <cstdio>

int main(int argc, char** argv) {
  using namespace isthmus;
  using namespace isthmus::client;
  const auto client = Client::Connect({.address = argc > 1 ? argv[1] : "localhost:50051"});
  if (!client.ok()) {
    std::fprintf(stderr, "%s\n", client.status().ToString().c_str());
    return 1;
  }
  // Appears under its name only once size and checksum are right.
  const auto file = (*client)->ExportToFile({.format = ExportFormat::kPly}, "merged.ply");
  if (!file.ok()) {
    std::fprintf(stderr, "%s\n", file.status().ToString().c_str());
    return 1;
  }
  std::printf("merged.ply: %zu bytes, revision %ld\n", static_cast<size_t>(file->size),
              static_cast<long>(file->revision));
}
