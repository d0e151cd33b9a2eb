#include "server/metrics/http_page.h"

#include <absl/strings/str_cat.h>
#include <civetweb.h>

#include <string_view>
#include <utility>

#include "core/caught.h"
#include "core/io/deferred_accept.h"
#include "server/metrics/limits.h"

namespace isthmus::metrics {
namespace {

constexpr char kPath[] = "/metrics", kPlain[] = "text/plain; charset=utf-8";
constexpr int kOk = 200, kNotFound = 404, kNotAllowed = 405, kOurs = 500;  // Format

// Returns the code. Whole: the library's own errors look for pages on the disk.
int Reply(mg_connection* connection, int code, const std::string& type, const std::string& text,
          bool with_text = true) {
  const char* const meaning = mg_get_response_code_text(connection, code);
  mg_printf(connection,
            "HTTP/1.1 %d %s\r\nContent-Type: %s\r\nContent-Length: %zu\r\n"
            "Cache-Control: no-store\r\nConnection: close\r\n\r\n",
            code, meaning, type.c_str(), text.size());
  if (with_text) mg_write(connection, text.data(), text.size());
  return code;
}

class CivetPage : public HttpPage {
 public:
  CivetPage(const std::string& content_type, Content content)
      : content_type_(content_type), content_(std::move(content)) {
    mg_init_library(0);
  }
  ~CivetPage() override {
    if (context_ != nullptr) mg_stop(context_);
    mg_exit_library();
  }

  absl::Status Listen(const std::string& listen);
  std::string address() const override { return address_; }

 private:
  static int Answer(mg_connection* connection, void* page);
  int Answer(mg_connection* connection) const;

  const std::string content_type_;
  const Content content_;
  std::string address_;
  mg_context* context_ = nullptr;
};

absl::Status CivetPage::Listen(const std::string& listen) {
  const size_t colon = listen.rfind(':');
  const std::string host = listen.substr(0, colon);
  // The library wants a number there.
  const std::string port = host == "localhost" ? "127.0.0.1" + listen.substr(colon) : listen;
  const std::string threads = absl::StrCat(kHttpThreads), timeout = absl::StrCat(kHttpTimeoutMs);
  const char* settings[] = {"listening_ports",    port.c_str(),    "num_threads", threads.c_str(),
                            "request_timeout_ms", timeout.c_str(), nullptr};
  const mg_callbacks callbacks = {};
  mg_init_data init = {&callbacks, nullptr, settings};
  char why[256] = "";
  unsigned code = 0;
  mg_error_data error = {&code, why, sizeof(why)};
  context_ = mg_start2(&init, &error);
  mg_server_port bound = {};
  if (context_ == nullptr || mg_get_server_ports(context_, 1, &bound) != 1) {
    return absl::UnavailableError(
        absl::StrCat("cannot serve metrics at ", listen,
                     ": the address is in use, or not one of this machine; name another one in "
                     "metrics.listen (",
                     why, ")"));
  }
  address_ = absl::StrCat(host, ":", bound.port);
  io::DeferAccept(bound.port);  // A connection that says nothing takes no thread.
  mg_set_request_handler(context_, "/", Answer, this);
  return absl::OkStatus();
}

// Nothing may be thrown into the library, which is written in C.
int CivetPage::Answer(mg_connection* connection, void* page) {
  try {
    return static_cast<const CivetPage*>(page)->Answer(connection);
  } catch (...) {
    return Reply(connection, kOurs, kPlain, std::string(CaughtStatus().message()) + "\n");
  }
}

int CivetPage::Answer(mg_connection* connection) const {
  const mg_request_info& request = *mg_get_request_info(connection);
  const std::string_view method = request.request_method;
  const char* const path = request.local_uri;
  if (path == nullptr || std::string_view(path) != kPath) {
    return Reply(connection, kNotFound, kPlain, absl::StrCat("the metrics are at ", kPath, "\n"));
  }
  if (method != "GET" && method != "HEAD") {
    return Reply(connection, kNotAllowed, kPlain, "the metrics can be read alone\n");
  }
  return Reply(connection, kOk, content_type_, content_(), method == "GET");
}

}  // namespace

absl::StatusOr<std::unique_ptr<HttpPage>> HttpPage::Serve(const std::string& listen,
                                                          const std::string& content_type,
                                                          Content content) {
  auto page = std::make_unique<CivetPage>(content_type, std::move(content));
  if (absl::Status status = page->Listen(listen); !status.ok()) return status;
  return page;
}

}  // namespace isthmus::metrics
