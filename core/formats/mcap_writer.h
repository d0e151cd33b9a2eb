// MCAP files (mcap.dev/spec, version 0), piece by piece: chunks with message indexes, a summary
// with statistics, and checksums over all of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace isthmus::formats {

// Messages are gathered into chunks, uncompressed, which hold the schemas and channels they are the
// first to need. Every byte goes to the sink in order, so the file may be a
// stream. Not thread safe.
class McapWriter {
 public:
  // Receives the next bytes of the file; false: they cannot be written, and nothing more comes.
  using Sink = std::function<bool(const std::string&)>;

  // A chunk is closed once it has so many bytes; smaller ones make the index long, larger ones make
  // readers that look for one message read more.
  explicit McapWriter(Sink sink, size_t chunk_bytes = size_t{1} << 20);

  // Both return their number. `encoding` is that of the schema ("protobuf"), `data` the schema.
  uint16_t AddSchema(const std::string& name, const std::string& encoding, const std::string& data);
  uint16_t AddChannel(uint16_t schema, const std::string& topic, const std::string& encoding);
  // Times are nanoseconds; negative ones count as 0.
  void Write(uint16_t channel, int64_t time_ns, const std::string& data);
  // The summary, and the end. False where any of the file could not be written.
  bool Finish();

 private:
  struct Channel {
    std::string record;
    uint32_t messages = 0;
    std::vector<std::pair<uint64_t, uint64_t>> index;  // Messages of the open chunk: time, offset.
  };
  struct ChunkPlace {
    uint64_t first_ns = 0, last_ns = 0, start = 0, length = 0, index_length = 0, size = 0;
    std::map<uint16_t, uint64_t> indexes;  // By channel: the offset of its index.
  };

  void Emit(const std::string& bytes);
  void FlushChunk();
  void WriteSummary();
  std::string Statistics() const;

  const Sink sink_;
  const size_t chunk_bytes_;
  bool is_well_ = true;
  uint64_t written_ = 0;
  uint32_t crc_ = 0;
  std::vector<std::string> schemas_;  // Their records; number i is i + 1.
  std::vector<Channel> channels_;     // Number i is i.
  std::string chunk_;
  uint64_t first_ns_ = 0, last_ns_ = 0;  // Times of the chunk's messages.
  std::vector<ChunkPlace> chunks_;
};

}  // namespace isthmus::formats
