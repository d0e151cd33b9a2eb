// A reader that has looked at its first scan.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/readers/scan_reader.h"

namespace isthmus::readers {

// Reads ahead to the first scan that can be read, so that the sensor and what was assumed are known
// before anything is done with it. Next gives everything that was read, errors too. Of a recording
// that begins with nothing but damage it reads a bounded part.
class StartedReader : public ScanReader {
 public:
  // Waits for the first scan of a live sensor.
  explicit StartedReader(std::unique_ptr<ScanReader> reader);

  // The first scan; null where there is none that can be read.
  const RecordedScan* first() const { return first_; }

  absl::StatusOr<std::optional<RecordedScan>> Next() override;
  std::optional<uint64_t> size() const override { return reader_->size(); }
  // The recording's, else as the first scan's rings tell.
  std::string sensor() const override { return sensor_; }
  bool has_stamps() const override { return reader_->has_stamps(); }
  std::vector<std::string> Assumptions() const override { return reader_->Assumptions(); }
  void Interrupt() override { reader_->Interrupt(); }

 private:
  const std::unique_ptr<ScanReader> reader_;
  std::deque<absl::StatusOr<std::optional<RecordedScan>>> ahead_;
  const RecordedScan* first_ = nullptr;  // In ahead_, until it is taken.
  std::string sensor_;
};

}  // namespace isthmus::readers
