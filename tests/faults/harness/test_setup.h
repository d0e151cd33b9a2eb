// A folder and the programs for one test.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <stdexcept>
#include <string>

#include "tests/faults/harness/fleet.h"

namespace isthmus::faults {

// The folder goes with it.
class TestSetup {
 public:
  explicit TestSetup(uint64_t seed = 1) {
    std::string pattern = testing::TempDir() + "isthmus-faults-XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
    setup_.folder = pattern;
    setup_.seed = seed;
    setup_.server = ISTHMUS_SERVER;
    setup_.robot = FAULT_ROBOT;
  }
  ~TestSetup() {
    std::error_code ignored;
    std::filesystem::remove_all(setup_.folder, ignored);
  }
  TestSetup(const TestSetup&) = delete;
  TestSetup& operator=(const TestSetup&) = delete;

  const Setup& get() const { return setup_; }
  std::string Path(const std::string& name) const { return setup_.folder + "/" + name; }

 private:
  Setup setup_;
};

}  // namespace isthmus::faults
