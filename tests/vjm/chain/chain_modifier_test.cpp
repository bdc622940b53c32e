#include "kinetostat/vjm/chain/chain_modifier.h"

#include <stdexcept>

#include <gtest/gtest.h>

#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/chain/kinematics.h"

#include "vjm/effect_catalogue.h"

namespace kinetostat::vjm::chain_modifier_test {
namespace {

using Eigen::VectorXd;
using spatial::Pose;

Chain slide_and_turn() {
  return ChainBuilder("c")
      .actuator("z", Motion::tz, 2e5)
      .offset(Pose::translation({0.3, 0, 0}))
      .passive("turn", Motion::rz)
      .offset(Pose::translation({0.2, 0, 0}))
      .build();
}

// Springs in series: 1/k = 1/k0 + c, of which scaling changes k0 alone.
TEST(ChainModifier, CompliancesInSeriesAddUpAndAreNotScaled) {
  ChainModifier modifier(slide_and_turn());
  modifier.add_series_compliance("z", 1e-6);
  modifier.add_series_compliance("z", 3e-6);
  EXPECT_NEAR(1 / modifier.chain().stiffness()(0, 0), 5e-6 + 4e-6, 1e-20);
  modifier.scale_spring("z", 2);
  EXPECT_NEAR(1 / modifier.chain().stiffness()(0, 0), 2.5e-6 + 4e-6, 1e-20);
  EXPECT_THROW(modifier.scale_spring("z", 0), std::invalid_argument);
  EXPECT_THROW(modifier.scale_spring("turn", 2), std::invalid_argument);
  EXPECT_THROW(modifier.add_series_compliance("turn", 1e-6), std::invalid_argument);
}

// A chain is a value: what is made from it leaves it as it was.
TEST(ChainModifier, LeavesTheChainThatItStartsFrom) {
  const Chain chain = slide_and_turn();
  ChainModifier modifier(chain);
  modifier.scale_spring("z", 3);
  modifier.add_displacement("end", false, spatial::Vector6::Constant(1e-3));
  modifier.add_compliance_behind("turn", "bearing", Motion::tx, 1e-7);
  const Chain changed = std::move(modifier).chain();
  const Chain longer = ChainBuilder(chain).offset(Pose::translation({0.1, 0, 0})).build();
  EXPECT_EQ(chain.size(), 2);
  EXPECT_EQ(changed.size(), 3);
  EXPECT_EQ(chain.stiffness()(0, 0), 2e5);
  EXPECT_FALSE(chain.has_errors());
  EXPECT_TRUE(changed.has_errors());
  ChainKinematics at;
  evaluate(chain, VectorXd::Zero(2), at);
  EXPECT_EQ(at.end.position().x(), 0.5);
  evaluate(longer, VectorXd::Zero(2), at);
  EXPECT_NEAR(at.end.position().x(), 0.6, 1e-15);
}

// The mass of what is mounted at the end stays where it is when the end alone is displaced.
TEST(ChainModifier, AMassAtTheEndIsBesideDisplacementsOfTheEnd) {
  const spatial::Vector3 center(0.01, 0.02, 0.03);
  ChainModifier modifier(slide_and_turn());
  modifier.add_displacement("end", false, spatial::Vector6::Constant(1e-2));
  modifier.add_mass_at_end("tool", 2, center);
  EXPECT_THROW(modifier.add_mass_at_end("tool", 2, center), std::invalid_argument);
  EXPECT_THROW(modifier.add_mass_at_end("lighter than air", -1, center), std::invalid_argument);
  ChainKinematics at;
  evaluate(modifier.chain(), VectorXd::Zero(2), at);
  ASSERT_EQ(at.nodes.size(), 1u);
  EXPECT_LT((at.nodes[0] - (spatial::Vector3(0.5, 0, 0) + center)).norm(), 1e-15);
}

void expect_same(const Pose& a, const Pose& b) {
  EXPECT_EQ(a.rotation(), b.rotation());
  EXPECT_EQ(a.position(), b.position());
}

// Whatever effects put on it.
TEST(ChainModifier, TakesAllBack) {
  int laws_alone = 0, others = 0;
  for (const test::Bench& bench : {test::parallel_bench(), test::arm_bench()})
    for (const Effect& effect : bench.effects) {
      if (!effect.kind->acts_on_chains()) continue;
      SCOPED_TRACE(bench.name + " " + effect.kind->name);
      const auto& [c, element] = effect.sites[0];
      const Chain& original = bench.manipulator.chains()[c];
      const Eigen::VectorXd history = Eigen::VectorXd::Zero(effect.kind->history);
      Conditions conditions;
      conditions.temperature = 30;
      ChainModifier modifier(original);
      for (int times = 0; times < 2; ++times) {
        effect.kind->act(modifier, element, {effect.values, conditions, history});
        const bool has_law = modifier.chain().laws().size() > original.laws().size();
        (has_law ? laws_alone : others) += 1;
        modifier.take_back(original);
        const Chain& back = modifier.chain();
        EXPECT_EQ(back.stiffness(), original.stiffness());
        EXPECT_EQ(back.laws().size(), original.laws().size());
        EXPECT_EQ(back.size(), original.size());
        EXPECT_EQ(back.masses().size(), original.masses().size());
        EXPECT_EQ(back.nodes().size(), original.nodes().size());
        EXPECT_EQ(back.displacements().size(), original.displacements().size());
        EXPECT_EQ(back.transmission_errors().size(), original.transmission_errors().size());
        ASSERT_EQ(back.joints().size(), original.joints().size());
        for (std::size_t j = 0; j < back.joints().size(); ++j)
          expect_same(back.joints()[j].before, original.joints()[j].before);
        expect_same(back.tail(), original.tail());
        EXPECT_EQ(back.has_errors(), original.has_errors());
      }
    }
  EXPECT_GT(laws_alone, 20);
  EXPECT_GT(others, 20);
}

}  // namespace
}  // namespace kinetostat::vjm::chain_modifier_test
