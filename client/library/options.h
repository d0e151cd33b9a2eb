// Options of a client: where its server is, and how long it keeps trying.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace isthmus::client {

class WaitClock;

// Waiting between attempts: first_delay_s, then `factor` times longer each time up to max_delay_s,
// each shortened by a random share of up to `jitter`, so that robots which lost the same server do
// not all come back in the same instant.
struct BackoffOptions {
  double first_delay_s = 0.2;
  double factor = 2;
  double max_delay_s = 5;
  double jitter = 0.3;   // [0, 1].
  int max_attempts = 8;  // The first one included; at least 1. At each address, where there are
                         // several.
  uint64_t seed = 0;     // For the jitter; 0: another one every time.
};

// PEM files, read when a connection is made, so that one that was renewed is used. Client::Connect
// says which one is not there (NotFound, for one) or holds something else (FailedPrecondition).
struct TlsOptions {
  // Authority that signed the server's certificate; "system": any authority this machine trusts.
  // Empty: plain text.
  std::string ca = {};
  std::string certificate = {}, key = {};  // Shown to a server that asks for it.
  std::string server_name = {};            // Expected name; empty: the address's.
};

struct ClientOptions {
  // host:port, or unix:PATH. Several of them, separated by commas, are those of servers of one map,
  // of which one has it: a call goes to the next where that of the last call is not there.
  std::string address = "localhost:50051";
  TlsOptions tls = {};
  // Shown with every call; empty: none. The space around it, such as the end of a file's line, is
  // none of it.
  std::string token = {};
  std::string site = {};  // One of the server's maps; empty: the only one that the token allows.
  // False: Client::Connect does not ask for a sign of life, so that a robot may begin out of reach
  // of its server; see Client::OpenSpool.
  bool require_server = true;
  BackoffOptions backoff = {};
  double call_timeout_s = 20;  // For an answer that the server has at hand.
  // For uploads, exports, queries, finishing a session, and what has the map placed anew.
  double transfer_timeout_s = 900;
  // An answer that is kept in memory, such as a list, may have so many bytes, ten times of it in
  // memory: a map of 100,000 submaps takes a third. Longer ones are refused.
  uint64_t max_answer_bytes = uint64_t{64} << 20;
  // The same bound for exports and queries, whose pieces are handed on as they come.
  uint64_t max_file_bytes = uint64_t{16} << 30;
  // Waits that many seconds; called from several threads. Null: sleeps. For tests.
  std::function<void(double)> sleep = nullptr;
  // All other waits use it; must outlive the client. Null: the machine's. For tests.
  const WaitClock* clock = nullptr;
};

}  // namespace isthmus::client
