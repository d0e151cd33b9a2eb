#include "tests/faults/harness/server_process.h"

#include <absl/strings/str_cat.h>
#include <signal.h>
#include <sys/resource.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

namespace isthmus::faults {

// The robots' room is closed: with `exact` no map is joined, and folders answer the same however
// often pairs are matched anew.
std::string ServerConfigText(int scans_per_submap) {
  return absl::StrCat("submaps: {cut_distance_m: 1000, cut_scans: ", scans_per_submap,
                      "}\n"
                      "revisits: {retire: false}\n"
                      "placement: {loops: false}\n"
                      "matching: {rematch_submaps: 1000, twins: exact}\n"
                      "ingest: {threads: 2}\n");
}

ServerProcess::ServerProcess(const std::string& program, const std::string& folder,
                             int scans_per_submap, const std::string& data,
                             const std::string& store)
    : program_(program),
      folder_(folder),
      data_(data.empty() ? folder + "/data" : data),
      store_(store) {
  std::filesystem::create_directories(folder);
  std::ofstream(folder_ + "/config.yaml") << ServerConfigText(scans_per_submap);
}

std::string ServerProcess::address() const { return absl::StrCat("unix:", folder_, "/robots"); }

std::string ServerProcess::own_address() const { return absl::StrCat("unix:", folder_, "/own"); }

void ServerProcess::Launch() {
  std::filesystem::remove(folder_ + "/own");
  std::vector<std::string> arguments = {"--data",      data_,      "--listen",
                                        own_address(), "--config", folder_ + "/config.yaml"};
  if (!store_.empty()) arguments.insert(arguments.end(), {"--store", store_});
  process_ = std::make_unique<ChildProcess>(program_, arguments, folder_ + "/log");
}

bool ServerProcess::WaitUntilUp() {
  if (!process_->ReadLine().empty()) return true;
  Wait();
  return false;
}

void ServerProcess::Publish() {
  std::rename((folder_ + "/own").c_str(), (folder_ + "/robots").c_str());
}

bool ServerProcess::Start() {
  Launch();
  if (!WaitUntilUp()) return false;
  Publish();
  return true;
}

void ServerProcess::LimitFiles(std::optional<uint64_t> bytes) const {
  const rlimit limit = {bytes.value_or(RLIM_INFINITY), RLIM_INFINITY};
  prlimit(process_->pid(), RLIMIT_FSIZE, &limit, nullptr);
}

int ServerProcess::End() {
  exit_code_ = process_->Wait();
  log_ = process_->Errors();
  process_.reset();
  return exit_code_;
}

void ServerProcess::Kill() {
  process_->Signal(SIGKILL);
  End();
}

int ServerProcess::Stop() {
  process_->Signal(SIGTERM);
  return End();
}

int ServerProcess::Wait() { return End(); }

}  // namespace isthmus::faults
