// Designs and signatures of one candidate.
#include "kinetostat/calibration/search/candidate.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "calibration/laboratory.h"
#include "calibration/random_matrix.h"

namespace kinetostat::calibration::candidate_test {
namespace {

using Eigen::MatrixXd;
using test::random_matrix;

int with_settled_weight(const std::vector<Candidate>& designs) {
  return static_cast<int>(
      std::count_if(designs.begin(), designs.end(), [](const Candidate& design) {
        const auto& parameters = design.effect.kind->parameters;
        for (std::size_t k = 0; k < parameters.size(); ++k)
          if (parameters[k].is_of_weight && design.effect.values[static_cast<Eigen::Index>(k)] != 0)
            return true;
        return false;
      }));
}

// Gravity, and no mass.
TEST(Designs, HaveNoSettledWeightWhereNothingWeighs) {
  const test::Laboratory laboratory(
      "kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\n"
      "gravity: {direction: [0, 0, -1]}\nchain_types:\n  cell:\n"
      "    - actuator: {name: q, axis: Tz, stiffness: 1000}\nmanipulator: {chain: cell}\n");
  const vjm::Robot& robot = laboratory.robot();
  const vjm::Manipulator& bare = robot.without_effects();
  ASSERT_FALSE(bare.has_weight());
  const vjm::Effect payload = candidates(robot, {"payload"}).at(0).effect;
  for (const char* kind : {"friction", "load_friction", "creep"}) {
    const Candidate candidate = candidates(robot, {kind}).at(0);
    const std::vector<Candidate> without = designs_of(candidate, bare);
    const std::vector<Candidate> with = designs_of(candidate, bare, {payload});
    EXPECT_FALSE(without.empty()) << kind;
    EXPECT_EQ(with_settled_weight(without), 0) << kind;
    EXPECT_EQ(with_settled_weight(with), std::ssize(without)) << kind;
    EXPECT_EQ(with.size(), 2 * without.size()) << kind;
  }
}

TEST(CandidateSignatures, DropWhatPointsAsAnEarlierOneDoes) {
  const MatrixXd a = random_matrix(30, 2, 1), b = random_matrix(30, 2, 2);
  MatrixXd turned = a;
  turned.col(1) += 0.05 * b.col(1);
  CandidateSignatures signatures;
  std::size_t number = 0;
  for (const MatrixXd& columns :
       {a, b, MatrixXd(0.2 * a), turned, MatrixXd(-a), MatrixXd(7 * b), MatrixXd(a.leftCols(1))}) {
    signatures.all.push_back({.columns = columns});
    signatures.starts.emplace_back().designs = ++number;
  }
  signatures.drop_repetitions();
  std::vector<std::size_t> kept;
  for (const Candidate& start : signatures.starts) kept.push_back(start.designs);
  EXPECT_EQ(kept, (std::vector<std::size_t>{1, 2, 4, 5, 7}));
  ASSERT_EQ(signatures.all.size(), kept.size());
  EXPECT_EQ(signatures.all[2].columns, turned);
}

}  // namespace
}  // namespace kinetostat::calibration::candidate_test
