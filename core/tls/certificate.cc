#include "core/tls/certificate.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>
#include <arpa/inet.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>

#include <array>
#include <ctime>
#include <memory>

#include "core/io/file_io.h"

namespace isthmus::tls {
namespace {

using Bio = std::unique_ptr<BIO, decltype(&BIO_free)>;
using X509Ptr = std::unique_ptr<X509, decltype(&X509_free)>;
using KeyPtr = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;

Bio BioOf(const std::string& pem) {
  return {BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), BIO_free};
}

X509Ptr ParseX509(const std::string& pem) {
  const Bio bio = BioOf(pem);
  return {PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr), X509_free};
}

std::string CommonName(const X509_NAME* name) {
  std::array<char, 256> text = {};
  X509_NAME_get_text_by_NID(const_cast<X509_NAME*>(name), NID_commonName, text.data(),
                            static_cast<int>(text.size()));
  return text.data();
}

absl::Time TimeOf(const ASN1_TIME* time) {
  std::tm tm = {};
  if (ASN1_TIME_to_tm(time, &tm) != 1) return absl::InfinitePast();
  return absl::FromTM(tm, absl::UTCTimeZone());
}

// "" for bytes that are no address: of another length than those have.
std::string AddressText(const ASN1_OCTET_STRING* address) {
  std::array<char, INET6_ADDRSTRLEN> text = {};
  const int size = ASN1_STRING_length(address);
  if (size != sizeof(in_addr) && size != sizeof(in6_addr)) return "";
  const int family = size == sizeof(in_addr) ? AF_INET : AF_INET6;
  inet_ntop(family, ASN1_STRING_get0_data(address), text.data(), text.size());
  return text.data();
}

std::vector<std::string> NamesOf(const X509* x509) {
  std::vector<std::string> names;
  auto* const all =
      static_cast<GENERAL_NAMES*>(X509_get_ext_d2i(x509, NID_subject_alt_name, nullptr, nullptr));
  for (int i = 0; i < sk_GENERAL_NAME_num(all); ++i) {
    const GENERAL_NAME* name = sk_GENERAL_NAME_value(all, i);
    if (name->type == GEN_DNS) {
      const auto* text = reinterpret_cast<const char*>(ASN1_STRING_get0_data(name->d.dNSName));
      names.emplace_back(text, static_cast<size_t>(ASN1_STRING_length(name->d.dNSName)));
    } else if (name->type == GEN_IPADD) {
      const std::string address = AddressText(name->d.iPAddress);
      if (!address.empty()) names.push_back(address);
    }
  }
  GENERAL_NAMES_free(all);
  return names;
}

// A key with a passphrase cannot be used by a server that starts by itself: none is asked for.
int NoPassphrase(char*, int, int, void*) { return -1; }

KeyPtr ParseKey(const std::string& pem) {
  const Bio bio = BioOf(pem);
  return {PEM_read_bio_PrivateKey(bio.get(), nullptr, NoPassphrase, nullptr), EVP_PKEY_free};
}

absl::Status NoCertificate(const std::string& path, absl::string_view why) {
  return absl::FailedPreconditionError(
      absl::StrCat(path, " is no certificate: ", why, "; `isthmus certs init` makes some"));
}

}  // namespace

absl::StatusOr<Certificate> ParseCertificate(const std::string& pem) {
  const X509Ptr x509 = ParseX509(pem);
  if (x509 == nullptr) {
    return absl::InvalidArgumentError("there is no certificate in PEM format in it");
  }
  Certificate certificate;
  certificate.subject = CommonName(X509_get_subject_name(x509.get()));
  certificate.issuer = CommonName(X509_get_issuer_name(x509.get()));
  certificate.names = NamesOf(x509.get());
  certificate.not_before = TimeOf(X509_get0_notBefore(x509.get()));
  certificate.not_after = TimeOf(X509_get0_notAfter(x509.get()));
  certificate.is_authority = X509_check_ca(x509.get()) > 0;
  return certificate;
}

absl::StatusOr<Certificate> ReadCertificate(const std::string& path) {
  const auto pem = io::ReadFile(path);
  if (!pem.ok()) return pem.status();
  auto certificate = ParseCertificate(*pem);
  if (certificate.ok()) return certificate;
  return NoCertificate(path, certificate.status().message());
}

absl::Status CheckCertificates(const std::string& path, const std::string& pem) {
  const Bio bio = BioOf(pem);
  ERR_clear_error();
  int count = 0;
  while (X509Ptr(PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr), X509_free)) ++count;
  const bool is_at_its_end = ERR_GET_REASON(ERR_peek_last_error()) == PEM_R_NO_START_LINE;
  ERR_clear_error();
  if (count > 0 && is_at_its_end) return absl::OkStatus();
  if (count == 0) return NoCertificate(path, "there is no certificate in PEM format in it");
  return NoCertificate(path, "one of those in it is cut off or damaged");
}

absl::Status CheckKeyPair(const std::string& certificate_path, const std::string& certificate,
                          const std::string& key_path, const std::string& key) {
  absl::Status status = CheckCertificates(certificate_path, certificate);
  if (!status.ok()) return status;
  const KeyPtr private_key = ParseKey(key);
  if (private_key == nullptr) {
    return absl::FailedPreconditionError(
        absl::StrCat(key_path,
                     " holds no private key in PEM format, or one with a passphrase: "
                     "give one without"));
  }
  const X509Ptr x509 = ParseX509(certificate);
  if (x509 == nullptr || X509_check_private_key(x509.get(), private_key.get()) != 1) {
    return absl::FailedPreconditionError(absl::StrCat(
        key_path, " is not the key of ", certificate_path, ": give the two of a pair"));
  }
  return absl::OkStatus();
}

absl::Status CheckIsSecret(const std::string& key_path) {
  struct stat state = {};
  if (stat(key_path.c_str(), &state) != 0) return io::FileError("read", key_path, errno);
  if ((state.st_mode & S_IRWXO) == 0) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat("everybody on this machine can read the key ",
                                                    key_path, ": chmod 600 ", key_path));
}

}  // namespace isthmus::tls
