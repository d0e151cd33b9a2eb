#include "server/matching/asking/asked_drives.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "server/matching/asking/driven_ways.h"
#include "server/matching/asking/forecast.h"
#include "server/matching/asking/limits.h"
#include "server/matching/asking/seen_ground.h"
#include "server/matching/pairs/decision.h"
#include "server/matching/pairs/probability.h"

namespace isthmus::matching {
namespace {

// The match as it would be decided with one of the hypotheses foreseen.
class Forecast {
 public:
  Forecast(const std::vector<Hypothesis>& ranked, size_t asked, const MatcherOptions& options)
      : asked_(asked), options_(options) {
    for (const Hypothesis& h : ranked) {
      Hypothesis figures = h;
      figures.joint = {};
      figures.agreement.clear();
      figures.things_a.clear();
      figures.things_b.clear();
      ranked_.push_back(std::move(figures));
    }
  }

  Match After(const Evidence& ahead, double known_m2) const {
    std::vector<Hypothesis> after = ranked_;
    std::swap(after[asked_], after.front());
    after.front() = Foresee(after.front(), ahead, known_m2);
    Match match;
    DecideState(after, options_, &match);
    return match;
  }

 private:
  const size_t asked_;
  const MatcherOptions options_;
  std::vector<Hypothesis> ranked_;
};

// A drive with all that it is chosen by.
struct Choice {
  AskedDrive drive;
  bool decides = false;
  double worth = 0;

  bool IsBetterThan(const Choice& other) const {
    return std::make_pair(decides, worth) > std::make_pair(other.decides, other.worth);
  }
};

// The pose at the stop by the newest of the driver's own submaps on the way to it.
std::vector<WayPoint> WayTo(size_t target, const DrivenWays& ways, const ShortestWays& shortest,
                            bool driver_is_b, uint32_t* leaves_own) {
  std::vector<size_t> order;
  for (std::optional<size_t> at = target; at; at = shortest.before[*at]) order.push_back(*at);
  std::reverse(order.begin(), order.end());
  std::vector<WayPoint> way;
  const Stop* own = nullptr;
  for (const size_t at : order) {
    const Stop& stop = ways.stops()[at];
    if (stop.of_b == driver_is_b) {
      own = &stop;
      *leaves_own = static_cast<uint32_t>(way.size());
    }
    const Pose T_submap_level = own->T_submap_sensor * own->T_level_sensor.Inverse();
    way.push_back({own->submap, T_submap_level * stop.T_level_sensor.translation()});
  }
  return way;
}

// The best drive of one robot for one hypothesis.
std::optional<Choice> BestOf(const DrivenWays& ways, bool driver_is_b, double probability,
                             bool outdoors, const PreparedMap& other, const Forecast& forecast) {
  const std::optional<size_t> start = ways.Newest(driver_is_b);
  if (!start) return std::nullopt;
  const ShortestWays shortest = ways.From(*start);
  const SharedGround ground =
      MeasureSharedGround(ways.stops(), shortest, driver_is_b, other, outdoors);
  std::optional<Choice> best;
  std::optional<size_t> target;
  for (size_t i = 0; i < ground.ahead.size(); ++i) {
    if (ground.ahead[i].ground_m2 <= 0) continue;
    const Match after = forecast.After(ground.ahead[i], ground.now_m2);
    Choice choice;
    choice.drive.by_b = driver_is_b;
    choice.drive.length_m = shortest.length_m[i];
    choice.drive.confidence = after.confidence;
    choice.decides = after.state == MatchState::kAccepted;
    if (after.confidence < std::max(probability, kLeastAfterwards)) continue;
    const double gained = choice.decides ? 1 : after.confidence - probability;
    choice.worth = probability * gained / (kDriveBeginsM + choice.drive.length_m);
    if (best && !choice.IsBetterThan(*best)) continue;
    best = std::move(choice);
    target = i;
  }
  if (best) {
    best->drive.way = WayTo(*target, ways, shortest, driver_is_b, &best->drive.leaves_own);
  }
  return best;
}

}  // namespace

std::vector<AskedDrive> AskForDrives(const PreparedMap& a, const PreparedMap& b,
                                     const std::vector<Hypothesis>& ranked,
                                     const MatcherOptions& options) {
  const std::vector<double> probabilities = Probabilities(ranked);
  std::optional<Choice> best[2];
  for (size_t i = 0; i < std::min(ranked.size(), kMaxAsked); ++i) {
    const Hypothesis& h = ranked[i];
    const bool is_placed = h.joint.poses.a.size() == a.submaps().size() &&
                           h.joint.poses.b.size() == b.submaps().size();
    if (!is_placed || probabilities[i] < kLeastProbability) continue;
    const DrivenWays ways(a, b, h.joint.poses);
    const Forecast forecast(ranked, i, options);
    for (const bool driver_is_b : {false, true}) {
      auto choice =
          BestOf(ways, driver_is_b, probabilities[i], h.outdoors, driver_is_b ? a : b, forecast);
      if (!choice) continue;
      choice->drive.rival = static_cast<uint32_t>(i);
      std::optional<Choice>& so_far = best[driver_is_b ? 1 : 0];
      if (!so_far || choice->IsBetterThan(*so_far)) so_far = std::move(choice);
    }
  }
  std::vector<AskedDrive> drives;
  if (best[1] && best[0] && best[1]->IsBetterThan(*best[0])) std::swap(best[0], best[1]);
  for (std::optional<Choice>& choice : best) {
    if (choice) drives.push_back(std::move(choice->drive));
  }
  return drives;
}

}  // namespace isthmus::matching
