#include "client/certificates/authority.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <arpa/inet.h>
#include <fcntl.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "core/io/file_io.h"

namespace isthmus::certificates {
namespace {

using Bio = std::unique_ptr<BIO, decltype(&BIO_free)>;
using Key = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;
using X509Ptr = std::unique_ptr<X509, decltype(&X509_free)>;

constexpr char kAuthorityName[] = "ca";

absl::Status Failed(const char* what) {
  std::array<char, 256> text = {};
  ERR_error_string_n(ERR_get_error(), text.data(), text.size());
  return absl::InternalError(absl::StrCat("cannot ", what, ": ", text.data()));
}

std::string TextOf(BIO* bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return {data, static_cast<size_t>(size)};
}

std::string PathOf(const std::string& folder, const std::string& name, const char* ending) {
  return absl::StrCat(folder, "/", name, ending);
}

// In place of what was there, whole or not at all.
absl::Status Replace(const std::string& path, const std::string& bytes, mode_t mode) {
  const std::string part = path + ".part";
  unlink(part.c_str());
  const int file = open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (file < 0) return io::FileError("write", part, errno);
  const bool written =
      write(file, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()) &&
      fsync(file) == 0;
  const int error = errno;
  close(file);
  if (!written) return io::FileError("write", part, error);
  if (rename(part.c_str(), path.c_str()) != 0) return io::FileError("write", path, errno);
  return absl::OkStatus();
}

bool Extend(X509* x509, X509* issuer, int kind, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer, x509, nullptr, nullptr, 0);
  X509_EXTENSION* extension = X509V3_EXT_nconf_nid(nullptr, &context, kind, value.c_str());
  if (extension == nullptr) return false;
  const bool added = X509_add_ext(x509, extension, -1) == 1;
  X509_EXTENSION_free(extension);
  return added;
}

bool SetSerial(X509* x509) {
  std::array<unsigned char, 16> random = {};
  if (RAND_bytes(random.data(), static_cast<int>(random.size())) != 1) return false;
  random[0] &= 0x7f;  // Positive.
  BIGNUM* number = BN_bin2bn(random.data(), static_cast<int>(random.size()), nullptr);
  const bool set = BN_to_ASN1_INTEGER(number, X509_get_serialNumber(x509)) != nullptr;
  BN_free(number);
  return set;
}

struct Wanted {
  std::string common_name;
  absl::Duration valid_for;
  std::vector<std::pair<int, std::string>> extensions;
};

// Clocks of robots may be behind: it is valid since a day ago.
X509Ptr Sign(const Wanted& wanted, EVP_PKEY* key, X509* issuer, EVP_PKEY* issuer_key) {
  X509Ptr x509(X509_new(), X509_free);
  X509* const raw = x509.get();
  X509* const signer = issuer == nullptr ? raw : issuer;
  const long seconds = static_cast<long>(absl::ToInt64Seconds(wanted.valid_for));
  constexpr long kDayS = 86'400;
  bool ok = X509_set_version(raw, X509_VERSION_3) == 1 && SetSerial(raw);
  ok = ok && X509_gmtime_adj(X509_getm_notBefore(raw), -kDayS) != nullptr;
  ok = ok && X509_gmtime_adj(X509_getm_notAfter(raw), seconds) != nullptr;
  ok = ok && X509_set_pubkey(raw, key) == 1;
  const auto* name = reinterpret_cast<const unsigned char*>(wanted.common_name.c_str());
  ok = ok && X509_NAME_add_entry_by_txt(X509_get_subject_name(raw), "CN", MBSTRING_UTF8, name, -1,
                                        -1, 0) == 1;
  ok = ok && X509_set_issuer_name(raw, X509_get_subject_name(signer)) == 1;
  for (const auto& [kind, value] : wanted.extensions) ok = ok && Extend(raw, signer, kind, value);
  ok = ok && X509_sign(raw, issuer_key, EVP_sha256()) > 0;
  if (!ok) x509.reset();
  return x509;
}

absl::Status WritePair(const std::string& folder, const std::string& name, X509* x509,
                       EVP_PKEY* key) {
  const Bio certificate(BIO_new(BIO_s_mem()), BIO_free), secret(BIO_new(BIO_s_mem()), BIO_free);
  if (PEM_write_bio_X509(certificate.get(), x509) != 1 ||
      PEM_write_bio_PrivateKey(secret.get(), key, nullptr, nullptr, 0, nullptr, nullptr) != 1) {
    return Failed("write a certificate");
  }
  constexpr mode_t kOwnersAlone = 0600, kEverybodys = 0644;
  absl::Status status = Replace(PathOf(folder, name, ".key"), TextOf(secret.get()), kOwnersAlone);
  if (!status.ok()) return status;
  return Replace(PathOf(folder, name, ".pem"), TextOf(certificate.get()), kEverybodys);
}

// A new key for `name`, signed by the folder's authority.
absl::Status Issue(const std::string& folder, const std::string& name, Wanted wanted) {
  const auto authority_pem = io::ReadFile(PathOf(folder, kAuthorityName, ".pem"));
  const auto authority_key = io::ReadFile(PathOf(folder, kAuthorityName, ".key"));
  if (!authority_pem.ok() || !authority_key.ok()) {
    return absl::NotFoundError(absl::StrCat(folder,
                                            " has no authority (ca.pem and ca.key): `isthmus "
                                            "certs init` makes one"));
  }
  const Bio pem(BIO_new_mem_buf(authority_pem->data(), static_cast<int>(authority_pem->size())),
                BIO_free);
  const Bio key_pem(BIO_new_mem_buf(authority_key->data(), static_cast<int>(authority_key->size())),
                    BIO_free);
  const X509Ptr issuer(PEM_read_bio_X509(pem.get(), nullptr, nullptr, nullptr), X509_free);
  const Key issuer_key(PEM_read_bio_PrivateKey(key_pem.get(), nullptr, nullptr, nullptr),
                       EVP_PKEY_free);
  if (issuer == nullptr || issuer_key == nullptr) return Failed("read the authority");
  wanted.extensions.emplace_back(NID_basic_constraints, "critical,CA:FALSE");
  wanted.extensions.emplace_back(NID_key_usage, "critical,digitalSignature");
  wanted.extensions.emplace_back(NID_authority_key_identifier, "keyid");
  const Key key(EVP_EC_gen("P-256"), EVP_PKEY_free);
  if (key == nullptr) return Failed("make a key");
  const X509Ptr x509 = Sign(wanted, key.get(), issuer.get(), issuer_key.get());
  if (x509 == nullptr) return Failed("sign a certificate");
  return WritePair(folder, name, x509.get(), key.get());
}

bool IsAddress(const std::string& host) {
  std::array<unsigned char, sizeof(in6_addr)> bytes = {};
  return inet_pton(AF_INET, host.c_str(), bytes.data()) == 1 ||
         inet_pton(AF_INET6, host.c_str(), bytes.data()) == 1;
}

// Names go into a list that commas part.
bool IsPlain(const std::string& name) {
  return !name.empty() && name.size() <= 253 && std::ranges::all_of(name, [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '_';
  });
}

}  // namespace

absl::Status MakeAuthority(const std::string& folder, absl::Duration valid_for) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return io::FileError("make the folder", folder, error.value());
  if (std::filesystem::exists(PathOf(folder, kAuthorityName, ".key"))) {
    return absl::AlreadyExistsError(
        absl::StrCat(folder,
                     " has an authority; `isthmus certs add` and `renew` use it, and to "
                     "begin anew choose another folder"));
  }
  const Key key(EVP_EC_gen("P-256"), EVP_PKEY_free);
  if (key == nullptr) return Failed("make a key");
  const Wanted wanted{"Isthmus field trial CA",
                      valid_for,
                      {{NID_basic_constraints, "critical,CA:TRUE,pathlen:0"},
                       {NID_key_usage, "critical,keyCertSign,cRLSign"},
                       {NID_subject_key_identifier, "hash"}}};
  const X509Ptr x509 = Sign(wanted, key.get(), nullptr, key.get());
  if (x509 == nullptr) return Failed("sign a certificate");
  return WritePair(folder, kAuthorityName, x509.get(), key.get());
}

absl::Status IssueServer(const std::string& folder, const std::vector<std::string>& hosts,
                         absl::Duration valid_for) {
  if (hosts.empty()) {
    return absl::InvalidArgumentError(
        "name the hosts and addresses under which robots reach the server");
  }
  std::string names;
  for (const std::string& host : hosts) {
    if (!IsAddress(host) && !IsPlain(host)) {
      return absl::InvalidArgumentError(absl::StrCat("\"", host,
                                                     "\" is neither a host nor an "
                                                     "address"));
    }
    absl::StrAppend(&names, names.empty() ? "" : ",", IsAddress(host) ? "IP:" : "DNS:", host);
  }
  return Issue(folder, kServerName,
               {hosts.front(),
                valid_for,
                {{NID_subject_alt_name, names}, {NID_ext_key_usage, "serverAuth"}}});
}

absl::Status IssueClient(const std::string& folder, const std::string& name,
                         absl::Duration valid_for) {
  if (!IsPlain(name) || name.front() == '.' || name == kServerName || name == kAuthorityName) {
    return absl::InvalidArgumentError(
        absl::StrCat("\"", name,
                     "\" cannot be a client's name: use letters, digits, \".\", \"-\" "
                     "and \"_\", and neither \"ca\" nor \"server\""));
  }
  return Issue(folder, name, {name, valid_for, {{NID_ext_key_usage, "clientAuth"}}});
}

}  // namespace isthmus::certificates
