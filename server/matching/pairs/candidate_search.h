// The search for ways in which two whole maps could lie on each other: what the searches propose,
// each refined rigidly.
#pragma once

#include <functional>
#include <stop_token>
#include <vector>

#include "core/map/match.h"
#include "server/matching/pairs/hypothesis.h"
#include "server/matching/prepared/prepared_map.h"
#include "server/matching/registration/candidate.h"
#include "server/matching/search/birds_eye_image.h"

namespace isthmus::matching {

// The search for one pair of maps. The maps must outlive it. Not thread safe.
class CandidateSearch {
 public:
  // With `stop` requested nothing more is found.
  CandidateSearch(const PreparedMap& a, const PreparedMap& b, std::stop_token stop = {});

  // False for transforms between the odom frames that need not be looked at.
  using Possible = std::function<bool(const Pose& T_a_b)>;

  // A look at the guesses, by what stands on the ground and by places, that overlap most: does one
  // of them agree with what both robots looked through, as where maps meet? True where that cannot
  // be told. Of a sensor that hangs, which few do, it sees nothing. What is found is left to the
  // searches.
  bool LooksPromising(std::vector<StageTime>* stages);

  // Each appends hypotheses that are not among `*found` yet, refined and with the free space of the
  // rigid alignment, and stage times. Only what is `possible`, where that is given, is refined.
  void ByBirdsEye(std::vector<Hypothesis>* found, std::vector<StageTime>* stages,
                  const Possible& possible = {});
  void ByStructure(std::vector<Hypothesis>* found, std::vector<StageTime>* stages);
  void ByPlaces(std::vector<Hypothesis>* found, std::vector<StageTime>* stages);
  // Finds nothing in a build without the paper's chain.
  void ByFeatures(std::vector<Hypothesis>* found, std::vector<StageTime>* stages);
  // Moves those that agree best by what either map repeats: where one rack or room fits, others
  // may.
  void ByRepeats(std::vector<Hypothesis>* found, std::vector<StageTime>* stages);
  // About a guess of anchors (AnchorPrior::Guess), and its standard deviation.
  void ByAnchors(const Pose& guess_T_a_b, double sigma_m, std::vector<Hypothesis>* found,
                 std::vector<StageTime>* stages);
  // From here on b is searched with the other end up, where it or a may be upside down; else false.
  bool TurnOver();
  void TakeCandidates(const std::vector<Candidate>& candidates, std::vector<Hypothesis>* found,
                      std::vector<StageTime>* stages);

  // Fills how far the maps repeat: once for a search, as it takes one of each map in itself.
  void MeasureRepetition(Hypothesis* h) const;
  // Fills the ground that both know; whole maps only.
  void MeasureShared(Hypothesis* h);

  bool outdoors() const { return scale_.outdoors; }
  uint32_t candidates() const { return candidates_; }  // Refined so far.

 private:
  // The candidates that overlap most.
  std::vector<Candidate> MostOverlapping(const std::vector<Candidate>& candidates,
                                         size_t limit) const;
  bool IsAmong(const std::vector<Candidate>& known, const Candidate& candidate) const;
  // The guesses, aligned coarsely: of those that come to one place the one that overlaps most.
  std::vector<Candidate> OneOfEachPlace(const std::vector<Candidate>& guesses) const;
  double UpCosine(const Pose& T_a_b) const;
  double Tilt(const Pose& T_a_b) const;
  // Candidates from above on the storeys that they suit best, where there are several.
  std::vector<Candidate> OnStoreys(const std::vector<Candidate>& candidates) const;

  const PreparedMap& a_;
  const PreparedMap& b_;
  const SceneScale scale_;
  const std::stop_token stop_;
  RefineOptions refine_options_;
  Eigen::Vector3d middle_b_ = Eigen::Vector3d::Zero();  // Mean of b's sensors, b's odom frame.
  const WallMap* walls_b_;
  BirdsEyeCells a_cells_, b_cells_, b_turned_cells_;
  uint32_t candidates_ = 0;
};

}  // namespace isthmus::matching
