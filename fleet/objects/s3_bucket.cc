#include "fleet/objects/s3_bucket.h"

#include <absl/strings/ascii.h>
#include <absl/strings/escaping.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>
#include <curl/curl.h>

#include <cstdlib>
#include <optional>
#include <thread>
#include <utility>

#include "core/io/sha256.h"
#include "fleet/objects/limits.h"

namespace isthmus::storage {
namespace {

// The text of the first such element behind `*from`, which is set behind it. Enough for the answers
// needed here: names of our own, times and messages.
std::optional<std::string> NextElement(const std::string& xml, const std::string& tag,
                                       size_t* from) {
  const std::string open = absl::StrCat("<", tag, ">"), close = absl::StrCat("</", tag, ">");
  const size_t begin = xml.find(open, *from);
  if (begin == std::string::npos) return std::nullopt;
  const size_t end = xml.find(close, begin);
  if (end == std::string::npos) return std::nullopt;
  *from = end + close.size();
  return xml.substr(begin + open.size(), end - begin - open.size());
}

std::string Element(const std::string& xml, const std::string& tag) {
  size_t from = 0;
  return NextElement(xml, tag, &from).value_or("");
}

// As a query has it: escapes every character that needs it.
std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    const bool is_plain = absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '-' ||
                          c == '_' || c == '.' || c == '~';
    if (is_plain) {
      escaped.push_back(c);
    } else {
      const std::string hex = absl::BytesToHexString(std::string(1, c));
      absl::StrAppend(&escaped, "%", absl::AsciiStrToUpper(hex));
    }
  }
  return escaped;
}

std::string Environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

// A part of a URL; empty where it has none.
std::string Part(CURLU* url, CURLUPart part) {
  char* text = nullptr;
  if (curl_url_get(url, part, &text, 0) != CURLUE_OK) return "";
  std::string copy = text;
  curl_free(text);
  return copy;
}

constexpr char kRegion[] = "region=";

absl::Status NotABucket(const std::string& why) {
  return absl::InvalidArgumentError(absl::StrCat(
      "the URL of a bucket is https://HOST/BUCKET/PREFIX?region=REGION, the last two as needed: ",
      why));
}

// The address of requests: scheme, host and port; bucket and prefix, which ends with /.
struct BucketPlace {
  std::string origin, path, region = "us-east-1";
};

absl::StatusOr<BucketPlace> ParseUrl(const std::string& text) {
  const std::unique_ptr<CURLU, decltype(&curl_url_cleanup)> url(curl_url(), curl_url_cleanup);
  if (curl_url_set(url.get(), CURLUPART_URL, text.c_str(), 0) != CURLUE_OK) {
    return NotABucket("this is no URL");
  }
  const std::string scheme = Part(url.get(), CURLUPART_SCHEME);
  if (scheme != "https" && scheme != "http") return NotABucket("this begins with neither");
  if (!absl::StrCat(Part(url.get(), CURLUPART_USER), Part(url.get(), CURLUPART_PASSWORD)).empty()) {
    return NotABucket("credentials come from AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY");
  }
  const std::string port = Part(url.get(), CURLUPART_PORT);
  BucketPlace place;
  place.origin =
      absl::StrCat(scheme, "://", Part(url.get(), CURLUPART_HOST), port.empty() ? "" : ":", port);
  if (const std::string query = Part(url.get(), CURLUPART_QUERY); !query.empty()) {
    if (!absl::StartsWith(query, kRegion)) return NotABucket("only a region can be asked for");
    place.region = query.substr(sizeof(kRegion) - 1);
  }
  place.path = Part(url.get(), CURLUPART_PATH);
  while (absl::StartsWith(place.path, "/")) place.path.erase(0, 1);
  if (place.path.empty()) return NotABucket("this names none");
  for (const char c : absl::StrCat(place.path, place.region)) {
    const bool is_known = absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '/' ||
                          c == '.' || c == '_' || c == '-';
    if (!is_known) return NotABucket("names have letters, digits and /._- only");
  }
  if (!absl::EndsWith(place.path, "/")) place.path.push_back('/');
  return place;
}

absl::Status FailureOf(int64_t code, const std::string& method, const std::string& url,
                       const std::string& body) {
  const std::string said = absl::StrCat(Element(body, "Code"), " ", Element(body, "Message"));
  const std::string what =
      absl::StrCat("the object store answers ", method, " ", url, " with ", code, " ", said);
  // A proxy's own 404, or a bucket's, says nothing about the object.
  if (code == 404 && Element(body, "Code") == "NoSuchKey") return absl::NotFoundError(what);
  if (code == 401 || code == 403) {
    return absl::PermissionDeniedError(absl::StrCat(
        what,
        "; are AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY right, and may they read, write, "
        "list and delete there? Is this machine's clock right?"));
  }
  if (code == 408 || code == 429 || code >= 500) return absl::UnavailableError(what);
  return absl::FailedPreconditionError(what);
}

}  // namespace

absl::Status CheckBucketUrl(const std::string& url) { return ParseUrl(url).status(); }

// A connection that may be kept from one request to the next.
class S3Bucket::Transfer {
 public:
  Transfer() : curl_(curl_easy_init()) {}
  ~Transfer() { curl_easy_cleanup(curl_); }
  Transfer(const Transfer&) = delete;
  Transfer& operator=(const Transfer&) = delete;

  absl::StatusOr<Answer> Run(const std::string& url, const std::string& region,
                             const Credentials& credentials, const Request& request) {
    if (curl_ == nullptr) return absl::ResourceExhaustedError("no memory for a request");
    curl_easy_reset(curl_);  // Not the connection.
    const std::string hash =
        absl::BytesToHexString(io::Sha256(request.body.data(), request.body.size()));
    curl_slist* headers = nullptr;
    const auto add = [&headers](const std::string& header) {
      headers = curl_slist_append(headers, header.c_str());
    };
    add(absl::StrCat("x-amz-content-sha256: ", hash));
    if (!credentials.session_token.empty()) {
      add(absl::StrCat("x-amz-security-token: ", credentials.session_token));
    }
    if (request.method == "PUT") add("Content-Type: application/octet-stream");
    const std::string signer = absl::StrCat("aws:amz:", region, ":s3");
    const std::string user = absl::StrCat(credentials.key_id, ":", credentials.secret);
    Answer answer;
    curl_easy_setopt(curl_, CURLOPT_URL, url.c_str());
    curl_easy_setopt(curl_, CURLOPT_AWS_SIGV4, signer.c_str());
    curl_easy_setopt(curl_, CURLOPT_USERPWD, user.c_str());
    if (request.method == "PUT") {
      curl_easy_setopt(curl_, CURLOPT_POSTFIELDS, request.body.data());
      curl_easy_setopt(curl_, CURLOPT_POSTFIELDSIZE_LARGE,
                       static_cast<curl_off_t>(request.body.size()));
    }
    curl_easy_setopt(curl_, CURLOPT_CUSTOMREQUEST, request.method.c_str());
    curl_easy_setopt(curl_, CURLOPT_HTTPHEADER, headers);
    // It asks for leave to send, and does not wait for the answer; an "Expect:" to keep it from
    // asking would be signed and not sent.
    curl_easy_setopt(curl_, CURLOPT_EXPECT_100_TIMEOUT_MS, 1L);
    curl_easy_setopt(curl_, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(curl_, CURLOPT_CONNECTTIMEOUT_MS, kConnectMs);
    curl_easy_setopt(curl_, CURLOPT_LOW_SPEED_LIMIT, 1L);
    curl_easy_setopt(curl_, CURLOPT_LOW_SPEED_TIME, kStandsStillS);
    curl_easy_setopt(curl_, CURLOPT_TIMEOUT, kLongestRequestS);
    curl_easy_setopt(curl_, CURLOPT_WRITEFUNCTION, &Transfer::Take);
    curl_easy_setopt(curl_, CURLOPT_WRITEDATA, &answer.body);
    const CURLcode code = curl_easy_perform(curl_);
    curl_slist_free_all(headers);
    if (code != CURLE_OK) {
      const std::string why =
          absl::StrCat("the object store at ", url, ": ", curl_easy_strerror(code));
      if (code == CURLE_OPERATION_TIMEDOUT) return absl::DeadlineExceededError(why);
      return absl::UnavailableError(why);
    }
    long status = 0;
    curl_easy_getinfo(curl_, CURLINFO_RESPONSE_CODE, &status);
    answer.code = status;
    return answer;
  }

 private:
  static size_t Take(char* bytes, size_t size, size_t count, void* body) {
    auto* taken = static_cast<std::string*>(body);
    if (taken->size() + size * count > kLargestAnswer) return 0;  // Ends the transfer.
    taken->append(bytes, size * count);
    return size * count;
  }

  CURL* const curl_;
};

S3Bucket::S3Bucket(std::string origin, std::string path, std::string region,
                   Credentials credentials)
    : origin_(std::move(origin)),
      bucket_(path.substr(0, path.find('/'))),
      prefix_(path.substr(path.find('/') + 1)),
      region_(std::move(region)),
      credentials_(std::move(credentials)) {}

S3Bucket::~S3Bucket() = default;

absl::StatusOr<std::unique_ptr<S3Bucket>> S3Bucket::Open(const std::string& url) {
  static const CURLcode kReady = curl_global_init(CURL_GLOBAL_DEFAULT);
  if (kReady != CURLE_OK) return absl::InternalError(curl_easy_strerror(kReady));
  absl::StatusOr<BucketPlace> place = ParseUrl(url);
  if (!place.ok()) return place.status();
  Credentials credentials = {Environment("AWS_ACCESS_KEY_ID"), Environment("AWS_SECRET_ACCESS_KEY"),
                             Environment("AWS_SESSION_TOKEN")};
  if (credentials.key_id.empty() || credentials.secret.empty()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "large values of the map are in ", url,
        ": set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY in this program's environment"));
  }
  return std::unique_ptr<S3Bucket>(new S3Bucket(std::move(place->origin), std::move(place->path),
                                                std::move(place->region), std::move(credentials)));
}

std::unique_ptr<S3Bucket::Transfer> S3Bucket::Borrow() {
  MutexLock lock(&mutex_);
  if (idle_.empty()) return std::make_unique<Transfer>();
  std::unique_ptr<Transfer> transfer = std::move(idle_.back());
  idle_.pop_back();
  return transfer;
}

void S3Bucket::Return(std::unique_ptr<Transfer> transfer) {
  MutexLock lock(&mutex_);
  if (idle_.size() < kIdleTransfers) idle_.push_back(std::move(transfer));
}

absl::StatusOr<S3Bucket::Answer> S3Bucket::AskOnce(const Request& request) {
  const std::string path =
      request.name.empty() ? bucket_ : absl::StrCat(bucket_, "/", prefix_, request.name);
  const std::string url = absl::StrCat(origin_, "/", path, request.query);
  std::unique_ptr<Transfer> transfer = Borrow();
  absl::StatusOr<Answer> answer = transfer->Run(url, region_, credentials_, request);
  if (!answer.ok()) return answer;
  Return(std::move(transfer));
  if (answer->code >= 200 && answer->code < 300) return answer;
  return FailureOf(answer->code, request.method, url, answer->body);
}

absl::StatusOr<std::string> S3Bucket::Ask(const Request& request) {
  absl::Duration pause = kFirstRetry;
  for (int attempt = 1;; ++attempt) {
    if (absl::Status away = IsAway(); !away.ok()) return away;
    absl::StatusOr<Answer> answer = AskOnce(request);
    if (answer.ok()) return std::move(answer->body);
    if (absl::IsDeadlineExceeded(answer.status())) {
      MutexLock lock(&mutex_);
      away_until_ = absl::Now() + kTakenForAway;
      away_ = absl::UnavailableError(answer.status().message());
      return away_;
    }
    if (attempt == kAttempts || !absl::IsUnavailable(answer.status())) return answer.status();
    std::this_thread::sleep_for(absl::ToChronoMilliseconds(pause));
    pause *= 2;
  }
}

absl::Status S3Bucket::IsAway() {
  MutexLock lock(&mutex_);
  return absl::Now() < away_until_ ? away_ : absl::OkStatus();
}

absl::Status S3Bucket::Put(const std::string& name, const std::string& bytes) {
  return Ask({.method = "PUT", .name = name, .body = bytes}).status();
}

absl::StatusOr<std::string> S3Bucket::Get(const std::string& name) {
  return Ask({.method = "GET", .name = name});
}

absl::Status S3Bucket::Delete(const std::string& name) {
  const absl::Status status = Ask({.method = "DELETE", .name = name}).status();
  return absl::IsNotFound(status) ? absl::OkStatus() : status;
}

absl::StatusOr<std::vector<std::string>> S3Bucket::List(const std::string& beginning) {
  std::vector<std::string> names;
  std::string last;  // Last name of the page before, as the bucket has it.
  while (true) {
    std::string query =
        absl::StrCat("?list-type=2&prefix=", Escaped(absl::StrCat(prefix_, beginning)));
    if (!last.empty()) absl::StrAppend(&query, "&start-after=", Escaped(last));
    const absl::StatusOr<std::string> page = Ask({.method = "GET", .query = query});
    if (!page.ok()) return page.status();
    const size_t before = names.size();
    size_t at = 0;
    while (const auto content = NextElement(*page, "Contents", &at)) {
      const std::string key = Element(*content, "Key");
      if (!absl::StartsWith(key, prefix_ + beginning) || key <= last) {
        return absl::UnavailableError("the object store lists objects that were not asked for");
      }
      names.push_back(key.substr(prefix_.size()));
      last = key;
    }
    if (names.size() == before) return names;
  }
}

}  // namespace isthmus::storage
