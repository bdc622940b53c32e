#include "kinetostat/io/link_result_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/json.h"

#include "support/random.h"
#include "support/temporary_folder.h"

namespace kinetostat::io::link_result_file_test {
namespace {

using testing::HasSubstr;

class LinkResultFile : public testing::Test {
 protected:
  // A compliance with these keys beside it.
  IdentifiedLink read(const Json& keys) const {
    test::Random random(1);
    Json json = to_json(spatial::Compliance6(1e-6 * random.positive_definite(), random.frame()));
    json.update(keys);
    return read_identified_link(folder_.file("bar.link.json", json.dump()));
  }
  std::string complaint(const Json& keys) const {
    try {
      (void)read(keys);
    } catch (const common::InputError& error) {
      return error.what();
    }
    return {};
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(LinkResultFile, MassCentreAndMeshAreRead) {
  const IdentifiedLink link = read(
      {{"mass", 2.5}, {"center_of_mass", {0.1, -0.2, 0.3}}, {"inputs", {{"mesh_sha256", "abc"}}}});
  EXPECT_EQ(link.mass, 2.5);
  EXPECT_EQ(link.center_of_mass, spatial::Vector3(0.1, -0.2, 0.3));
  EXPECT_EQ(link.mesh_sha256, "abc");
}

TEST_F(LinkResultFile, ALinkMayHaveNoMassAndNoMesh) {
  for (const Json& inputs : {Json(), Json("none"), Json{{"mesh_sha256", 7}}}) {
    const IdentifiedLink link = read({{"mass", nullptr}, {"inputs", inputs}});
    EXPECT_EQ(link.mass, std::nullopt);
    EXPECT_EQ(link.mesh_sha256, "");
  }
}

TEST_F(LinkResultFile, AMassThatIsNoneNamesItsKey) {
  EXPECT_EQ(complaint(Json::object()), "");
  for (const Json& mass : {Json(0), Json(-1), Json("2 kg"), Json::array()})
    EXPECT_THAT(complaint({{"mass", mass}}), HasSubstr("bar.link.json: mass: a number above zero"));
  for (const Json& centre : {Json(), Json{1, 2}, Json{1, 2, "x"}})
    EXPECT_THAT(complaint({{"mass", 1}, {"center_of_mass", centre}}),
                HasSubstr("bar.link.json: center_of_mass: three numbers"));
}

}  // namespace
}  // namespace kinetostat::io::link_result_file_test
