#include "kinetostat/io/material_table.h"

#include <cmath>
#include <set>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace kinetostat::io::material_table_test {
namespace {

TEST(MaterialTable, HasTwentyMaterialsWithSourcesAndSpreads) {
  std::set<std::string> names;
  for (const NamedMaterial& m : named_materials()) {
    EXPECT_TRUE(names.insert(m.name).second) << m.name;
    EXPECT_EQ(m.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_"), std::string::npos);
    EXPECT_FALSE(m.words.empty() || m.source.empty() || m.spread.empty()) << m.name;
    EXPECT_GT(m.deviation, 0.005 * m.young) << m.name;
    EXPECT_LT(m.deviation, 0.25 * m.young) << m.name;
    EXPECT_GT(m.poisson, 0.15) << m.name;
    EXPECT_LT(m.poisson, 0.4) << m.name;
  }
  EXPECT_GE(names.size(), 20u);
  EXPECT_THROW(named_material("unobtainium"), std::out_of_range);
}

// The range of the standard is a rectangle about its middle.
TEST(MaterialTable, ARangeIsARectangle) {
  const NamedMaterial& iron = named_material("cast_iron_gjl_250");
  EXPECT_NEAR(iron.young, (103e9 + 118e9) / 2, 1);
  EXPECT_NEAR(iron.deviation, (118e9 - 103e9) / std::sqrt(12.0), 1);
}

// Metals are about as stiff for their weight as each other: E / density is near 25e6 m^2/s^2.
TEST(MaterialTable, MetalsHaveTheirSpecificStiffness) {
  for (const char* name :
       {"steel_s235", "stainless_1_4404", "aluminium_6082", "magnesium_az31", "titanium_ti6al4v"}) {
    const NamedMaterial& metal = named_material(name);
    EXPECT_NEAR(metal.young / metal.density, 25.5e6, 2e6) << name;
  }
}

}  // namespace
}  // namespace kinetostat::io::material_table_test
