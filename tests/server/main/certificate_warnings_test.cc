#include "server/main/certificate_warnings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "client/certificates/authority.h"

namespace isthmus::server {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int64_t kDayNs = int64_t{24} * 3600 * 1'000'000'000;

class CertificateWarningsTest : public testing::Test {
 protected:
  CertificateWarningsTest() : folder_(MakeFolder()), clock_(Clock::System().NowNs()) {
    if (!certificates::MakeAuthority(folder_, absl::Hours(24 * 365)).ok()) {
      throw std::runtime_error("no authority");
    }
  }
  ~CertificateWarningsTest() override { std::filesystem::remove_all(folder_); }

  static std::string MakeFolder() {
    std::string folder = testing::TempDir() + "isthmus-warnings-XXXXXX";
    if (mkdtemp(folder.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
    return folder;
  }
  void Issue(int days) {
    const absl::Status status =
        certificates::IssueServer(folder_, {"localhost"}, absl::Hours(24 * days));
    ASSERT_TRUE(status.ok()) << status;
  }
  // The warnings after that many days.
  std::vector<std::string> After(double days) {
    said_.clear();
    clock_.Advance(static_cast<int64_t>(days * kDayNs));
    warnings_.Check();
    return said_;
  }

  const std::string folder_;
  ManualClock clock_;
  std::vector<std::string> said_;
  CertificateWarnings warnings_{
      {folder_ + "/server.pem", folder_ + "/server.key"},
      [this](const std::string& text) { said_.push_back("warn " + text); },
      [this](const std::string& text) { said_.push_back("info " + text); },
      clock_};
};

TEST_F(CertificateWarningsTest, OneThatExpiresIsNamedOnceADay) {
  Issue(60);
  EXPECT_THAT(After(0), IsEmpty());
  EXPECT_THAT(After(45), IsEmpty());
  const auto soon = AllOf(HasSubstr("warn"), HasSubstr("server.pem expires on"),
                          HasSubstr("isthmus certs renew"));
  EXPECT_THAT(After(2), ElementsAre(soon));
  EXPECT_THAT(After(0.5), IsEmpty());
  EXPECT_THAT(After(0.6), ElementsAre(soon));
  EXPECT_THAT(After(20), ElementsAre(HasSubstr("has expired on")));
}

TEST_F(CertificateWarningsTest, ARenewedOneIsSaidToBe) {
  Issue(10);
  EXPECT_THAT(After(8), ElementsAre(HasSubstr("expires on")));
  Issue(90);
  EXPECT_THAT(After(0.1), ElementsAre(AllOf(HasSubstr("info"), HasSubstr("was renewed"))));
  EXPECT_THAT(After(0.1), IsEmpty());
}

TEST_F(CertificateWarningsTest, OfOneWithAShortLifeTheLastThirdIsLate) {
  Issue(3);
  EXPECT_THAT(After(1.5), IsEmpty());
  EXPECT_THAT(After(0.7), ElementsAre(HasSubstr("expires on")));
}

TEST_F(CertificateWarningsTest, AFileThatIsGoneIsNamed) {
  EXPECT_THAT(After(0), ElementsAre(AllOf(HasSubstr("server.pem"), HasSubstr("continues with"))));
}

TEST_F(CertificateWarningsTest, AKeyOfAnotherOneIsNamed) {
  Issue(60);
  std::filesystem::copy(folder_ + "/ca.key", folder_ + "/server.key",
                        std::filesystem::copy_options::overwrite_existing);
  EXPECT_THAT(After(0),
              ElementsAre(AllOf(HasSubstr("is not the key"), HasSubstr("continues with"))));
}

}  // namespace
}  // namespace isthmus::server
