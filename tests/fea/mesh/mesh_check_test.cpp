#include "kinetostat/fea/mesh/mesh_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"

#include "fea/shapes.h"

namespace kinetostat::fea::mesh_check_test {
namespace {

using testing::HasSubstr;

class MeshCheck : public testing::Test {
 protected:
  SurfaceCheck check(const SurfaceMesh& surface, const SurfaceCheckOptions& options) const {
    common::Progress silent;
    return check_surface_file(folder_.file("part.stl", binary_stl(surface, 1)), options, silent);
  }

 private:
  TemporaryFolder folder_;
};

const SurfaceMesh box = box_surface({0, 0, 0}, {1, 2, 3});

TEST_F(MeshCheck, WeighsASoundSurface) {
  const SurfaceCheck found = check(box, {.unit = "m", .repair = {}});
  EXPECT_TRUE(found.report.sound());
  EXPECT_NEAR(found.mass.volume, 6, 1e-12);
  EXPECT_EQ(found.bodies.size(), 1u);
  EXPECT_TRUE(found.repair.actions.empty());
}

TEST_F(MeshCheck, OneOfSeveralBodiesIsPickedByName) {
  SurfaceMesh two = box;
  append(two, box_surface({10, 0, 0}, {11, 1, 1}));
  EXPECT_EQ(check(two, {.unit = "m", .repair = {}}).bodies.size(), 2u);
  const SurfaceCheck second = check(two, {.unit = "m", .body = "2", .repair = {}});
  EXPECT_EQ(second.picked, "2");
  EXPECT_EQ(second.picked_of, 2u);
  EXPECT_NEAR(second.mass.volume, 1, 1e-12);
  try {
    (void)check(two, {.unit = "m", .body = "lid", .repair = {}});
    FAIL() << "a body that is not there";
  } catch (const common::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("there is no body 'lid'. The bodies are 1 (1 x 2 x 3 m)"));
  }
}

TEST_F(MeshCheck, RepairsOnlyWhenAsked) {
  const SurfaceMesh inside_out = inverted(box);
  EXPECT_FALSE(check(inside_out, {.unit = "m", .repair = {}}).report.sound());
  const SurfaceCheck repaired =
      check(inside_out, {.unit = "m", .repair = {.steps = {RepairStep::orient}}});
  EXPECT_TRUE(repaired.report.sound());
  ASSERT_EQ(repaired.repair.actions.size(), 1u);
  EXPECT_TRUE(repaired.repair.actions[0].done);
}

TEST_F(MeshCheck, KnowsAVolumeMeshByItsElements) {
  const TemporaryFolder folder;
  std::string inp =
      "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4,ELSET=part\n1,1,2,3,4\n";
  common::Progress silent;
  const VolumeCheck found = check_volume_file(folder.file("part.inp", inp), "m", silent);
  EXPECT_EQ(found.pieces, 1);
  EXPECT_NEAR(found.mass.volume, 1.0 / 6, 1e-15);
  // Of the corner of a cube: between its faces 90 degrees, to the slanted one acos(1 / sqrt 3).
  EXPECT_NEAR(found.quality.least_dihedral, 54.7356, 1e-3);
}

}  // namespace
}  // namespace kinetostat::fea::mesh_check_test
