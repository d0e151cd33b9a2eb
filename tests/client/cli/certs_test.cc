// isthmus certs: validity of the certificates that it signs.
#include <absl/time/clock.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/tls/certificate.h"
#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

class CertsCommandTest : public testing::Test {
 protected:
  CertsCommandTest() : folder_(ScratchFolder() + "/certs") {}
  ~CertsCommandTest() override {
    std::filesystem::remove_all(std::filesystem::path(folder_).parent_path());
  }

  // Hours left of the server's certificate.
  double HoursLeft() const {
    const auto certificate = tls::ReadCertificate(folder_ + "/server.pem");
    EXPECT_TRUE(certificate.ok()) << certificate.status();
    return certificate.ok() ? absl::ToDoubleHours(certificate->not_after - absl::Now()) : 0;
  }

  const std::string folder_;
};

TEST_F(CertsCommandTest, DaysMayBeAFraction) {
  const ProgramResult made = Isthmus("certs init " + folder_ + " --host localhost --days 0.5");
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_NEAR(HoursLeft(), 12, 0.1);
  EXPECT_THAT(made.out, testing::HasSubstr(", 0.50 days localhost"));

  ASSERT_EQ(Isthmus("certs renew " + folder_ + " --days 30").code, 0);
  EXPECT_NEAR(HoursLeft(), 30 * 24, 0.1);
  EXPECT_THAT(Isthmus("certs show " + folder_).out, testing::HasSubstr(", 30 days localhost"));
}

TEST_F(CertsCommandTest, RefusesWhatIsNoValidity) {
  ASSERT_EQ(Isthmus("certs init " + folder_ + " --host localhost").code, 0);
  EXPECT_NEAR(HoursLeft(), 397 * 24, 0.1);
  EXPECT_EQ(Isthmus("certs renew " + folder_ + " --days 0").code, 2);
  EXPECT_EQ(Isthmus("certs renew " + folder_ + " --days -1").code, 2);
  EXPECT_NEAR(HoursLeft(), 397 * 24, 0.1);
}

}  // namespace
}  // namespace isthmus::cli
