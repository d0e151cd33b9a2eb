// Rooms and doors found on floor plans against true ones. lab/docs/rooms.md says how to use it.
#include <absl/strings/str_format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "lab/bench/cpu_clock.h"
#include "lab/bench/rooms/drawn_house.h"
#include "lab/bench/rooms/judge.h"
#include "lab/bench/rooms/plan_images.h"

namespace isthmus::bench {
namespace {

struct Options {
  std::string plans;
  std::vector<std::string> names;
  int houses = 0;
  uint64_t seed = 0;
};

// A plan, bare or furnished, and the cells on which areas are compared.
struct Case {
  const char* kind;
  const floors::GridMap& map;
  const floors::GridMap& ground;
};

void PrintRow(const std::string& name, const char* kind, const RoomScore& score, double ms) {
  absl::PrintF("| %s | %s | %.1f | %.1f | %d | %d | %d | %d | %d | %d | %.0f |\n", name, kind,
               100 * score.recall, 100 * score.precision, score.true_rooms, score.found_rooms,
               score.true_doors, score.doors_found, score.found_doors, score.doors_right, ms);
}

absl::Status Judge(const std::string& name, const Case& plan, const TrueRooms& truth,
                   std::vector<RoomScore>* scores) {
  const CpuClock clock(CpuClock::Of::kProcess);
  const auto found = floors::RoomsOf(plan.map);
  const double ms = clock.Ms();
  if (!found.ok()) return found.status();
  scores->push_back(JudgeRooms(*found, truth, plan.ground));
  PrintRow(name, plan.kind, scores->back(), ms);
  return absl::OkStatus();
}

// Means over plans and the worst one's; sums of rooms and doors.
void PrintAll(const char* kind, const std::vector<RoomScore>& scores) {
  RoomScore all;
  for (const RoomScore& score : scores) all.Add(score);
  all.recall /= static_cast<double>(scores.size());
  all.precision /= static_cast<double>(scores.size());
  PrintRow("all", kind, all, 0);
  const auto worst = [&scores](double RoomScore::*figure) {
    double least = 1;
    for (const RoomScore& score : scores) least = std::min(least, score.*figure);
    return 100 * least;
  };
  absl::PrintF("\n%s: worst recall %.1f, worst precision %.1f\n", kind, worst(&RoomScore::recall),
               worst(&RoomScore::precision));
}

absl::Status Run(const Options& options) {
  std::vector<RoomScore> bare, furnished;
  const std::vector<std::string> names =
      options.names.empty() && !options.plans.empty() ? PlansIn(options.plans) : options.names;
  for (const std::string& name : names) {
    const auto plan = ReadPlan(options.plans, name);
    if (!plan.ok()) return plan.status();
    // Ground under furniture counts as in the survey.
    absl::Status status = Judge(name, {"bare", plan->bare, plan->bare}, plan->truth, &bare);
    status.Update(Judge(name, {"furnished", plan->furnished, plan->bare}, plan->truth, &furnished));
    if (!status.ok()) return status;
  }
  for (int i = 0; i < options.houses; ++i) {
    const uint64_t seed = options.seed + static_cast<uint64_t>(i);
    const DrawnHouse house = DrawHouse(seed);
    const std::string name = absl::StrFormat("house %d", seed);
    absl::Status status = Judge(name, {"bare", house.bare, house.bare}, house.truth, &bare);
    status.Update(
        Judge(name, {"furnished", house.furnished, house.furnished}, house.truth, &furnished));
    if (!status.ok()) return status;
  }
  if (bare.empty()) return absl::InvalidArgumentError("give --plans FOLDER or --houses N");
  PrintAll("bare", bare);
  PrintAll("furnished", furnished);
  return absl::OkStatus();
}

int Main(int argc, char** argv) {
  CLI::App app("Rooms and doors that are found on floor plans against the true ones");
  Options options;
  app.add_option("--plans", options.plans, "FOLDER of ipa_room_segmentation's images");
  app.add_option("--names", options.names, "Plans in it; without it all");
  app.add_option("--houses", options.houses, "Number of simulated houses");
  app.add_option("--seed", options.seed, "Of the first house")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  absl::PrintF(
      "| plan | kind | recall %% | precision %% | true rooms | found | true doors | of these found "
      "| found doors | of these true | ms |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  const absl::Status status = Run(options);
  if (status.ok()) return 0;
  std::cerr << status << "\n";
  return 1;
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) { return isthmus::bench::Main(argc, argv); }
