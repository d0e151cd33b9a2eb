#include "core/address.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace isthmus {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(Address, WhatCanBeReachedIsTaken) {
  for (const char* address : {"localhost:1", "robot.local:65535", "[::1]:50051", "10.0.0.7:50051",
                              "unix:/run/isthmus.sock", "dns:///server:50051"}) {
    EXPECT_TRUE(CheckAddress(address).ok()) << CheckAddress(address);
  }
}

TEST(Address, WhatCannotBeReachedIsRefusedAndTheMessageSaysWhatToWrite) {
  for (const char* address :
       {"", "localhost", ":50051", "localhost:", "localhost:http", "localhost:0", "localhost:65536",
        "localhost:-1", "localhost:+5", "localhost: 5", "localhost:99999999999999999999", "[::1]",
        "::", "localhost:0x10", "unix:", "unix-abstract:"}) {
    const absl::Status status = CheckAddress(address);
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << address;
    EXPECT_THAT(std::string(status.message()), HasSubstr("write HOST:PORT")) << address;
  }
  EXPECT_THAT(std::string(CheckAddress("localhost:70000").message()),
              AllOf(HasSubstr("\"localhost:70000\""), HasSubstr("1 to 65535")));
}

TEST(Address, AServerMayTakeAnyPortThatIsFree) {
  EXPECT_TRUE(CheckAddress("127.0.0.1:0", PortZero::kAnyFreeOne).ok());
  EXPECT_FALSE(CheckAddress("127.0.0.1:65536", PortZero::kAnyFreeOne).ok());
}

TEST(Address, SeveralAreThoseOfServersOfOneMap) {
  EXPECT_EQ(SplitAddresses("a:1"), std::vector<std::string>{"a:1"});
  EXPECT_EQ(SplitAddresses("a:1, [::1]:2,unix:/x"),
            (std::vector<std::string>{"a:1", "[::1]:2", "unix:/x"}));
  EXPECT_TRUE(CheckAddresses("a:1,b:2").ok());
  for (const char* addresses : {"", "a:1,", ",b:2", "a:1,b"}) {
    EXPECT_FALSE(CheckAddresses(addresses).ok()) << addresses;
  }
}

}  // namespace
}  // namespace isthmus
