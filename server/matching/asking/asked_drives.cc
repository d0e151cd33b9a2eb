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

// The hypotheses without all that a decision does not look at.
std::vector<Hypothesis> FiguresOf(std::vector<Hypothesis> hypotheses) {
  for (Hypothesis& h : hypotheses) {
    h.joint = {};
    h.agreement.clear();
    h.things_a.clear();
    h.things_b.clear();
  }
  return hypotheses;
}

// The match as it would be decided with one of the hypotheses foreseen.
class Forecast {
 public:
  // Both must outlive it.
  Forecast(const std::vector<Hypothesis>& figures, size_t asked, const MatcherOptions& options)
      : figures_(figures), asked_(asked), options_(options) {}

  Match After(const Evidence& ahead, double known_m2) const {
    std::vector<Hypothesis> after = figures_;
    std::swap(after[asked_], after.front());
    after.front() = Foresee(after.front(), ahead, known_m2);
    Match match;
    DecideState(after, options_, &match);
    return match;
  }

 private:
  const std::vector<Hypothesis>& figures_;
  const size_t asked_;
  const MatcherOptions& options_;
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

// A hypothesis that is asked about.
struct Question {
  const PreparedMap &a, &b;
  const Hypothesis& h;
  double probability = 0;
  const Forecast& forecast;
  DrivenWays ways{a, b, h.joint.poses};

  const PreparedMap& MapOf(bool robot_is_b) const { return robot_is_b ? b : a; }
};

// Nobody drives for less.
double LeastAfter(double probability) {
  return std::max(kLeastAfterwards, 1 - kDoubtLeft * (1 - probability));
}

// The way, each point by the submap where the driver was last on it.
void AddWay(size_t target, const Question& question, const EasiestWays& easiest,
            AskedDrive* drive) {
  std::vector<size_t> order;
  for (std::optional<size_t> at = target; at; at = easiest.before[*at]) order.push_back(*at);
  std::reverse(order.begin(), order.end());
  const auto& submaps = question.MapOf(drive->by_b).session_map().submaps;
  const Stop* own = nullptr;
  for (const size_t at : order) {
    const Stop& stop = question.ways.stops()[at];
    if (stop.of_b == drive->by_b) {
      own = &stop;
      drive->leaves_own = static_cast<uint32_t>(drive->way.size());
    }
    const Pose T_submap_level = own->T_submap_sensor * own->T_level_sensor.Inverse();
    drive->way.push_back(
        {submaps[own->submap]->id.index, T_submap_level * stop.T_level_sensor.translation()});
  }
}

// The best drive of one robot.
std::optional<Choice> BestOf(const Question& question, bool driver_is_b) {
  const DrivenWays& ways = question.ways;
  const std::optional<size_t> start = ways.Newest(driver_is_b);
  if (!start) return std::nullopt;
  const EasiestWays easiest = ways.From(*start);
  const SharedGround ground = MeasureSharedGround(
      ways.stops(), easiest, driver_is_b, question.MapOf(!driver_is_b), question.h.outdoors);
  std::optional<Choice> best;
  size_t target = 0;
  for (size_t i = 0; i < ground.ahead.size(); ++i) {
    if (ground.ahead[i].ground_m2 <= 0) continue;
    const Match after = question.forecast.After(ground.ahead[i], ground.now_m2);
    if (after.confidence < LeastAfter(question.probability)) continue;
    Choice choice;
    choice.drive.by_b = driver_is_b;
    choice.drive.length_m = easiest.length_m[i];
    choice.drive.confidence = after.confidence;
    choice.decides = after.state == MatchState::kAccepted;
    choice.worth = choice.decides
                       ? question.probability / (kDriveBeginsM + choice.drive.length_m)
                       : question.probability * (after.confidence - question.probability);
    if (best && !choice.IsBetterThan(*best)) continue;
    best = std::move(choice);
    target = i;
  }
  if (best) AddWay(target, question, easiest, &best->drive);
  return best;
}

bool IsPlaced(const PreparedMap& a, const PreparedMap& b, const MapPoses& poses) {
  return poses.a.size() == a.submaps().size() && poses.b.size() == b.submaps().size();
}

}  // namespace

std::vector<AskedDrive> AskForDrives(const PreparedMap& a, const PreparedMap& b,
                                     const std::vector<Hypothesis>& ranked,
                                     const MatcherOptions& options) {
  const std::vector<double> probabilities = Probabilities(ranked);
  const std::vector<Hypothesis> figures = FiguresOf(ranked);
  std::optional<Choice> best[2];
  for (size_t i = 0; i < std::min(ranked.size(), kMaxAsked); ++i) {
    if (!IsPlaced(a, b, ranked[i].joint.poses) || probabilities[i] < kLeastProbability) continue;
    const Forecast forecast(figures, i, options);
    const Question question{a, b, ranked[i], probabilities[i], forecast};
    for (const bool driver_is_b : {false, true}) {
      std::optional<Choice> choice = BestOf(question, driver_is_b);
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
