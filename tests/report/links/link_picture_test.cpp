#include "kinetostat/report/links/link_picture.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "fea/reference_bar.h"
#include "fea/shapes.h"

namespace kinetostat::report::link_picture_test {
namespace {

using io::Json;

using fea::LinkResult;
using spatial::Matrix6;
using spatial::Vector3;

constexpr double result_unit = 1e-3;

class LinkPicture : public testing::Test {
 protected:
  static LinkResult solved() {
    const fea::ReferenceBar bar(0.012);
    LinkResult result("bar", {bar.steel});
    result.mesh = bar.mesh;
    result.unit = "mm";
    result.interfaces = coupled_ends(bar.mesh);
    result.interfaces[1].point = bar.tip;
    common::Progress silent;
    result.response = respond(bar.mesh, {bar.steel}, result.interfaces, {}, silent);
    return result;
  }
  static const LinkResult& result() {
    static const LinkResult once = solved();
    return once;
  }
};

Vector3 entry(const Json& list, std::size_t i, double unit) {
  return unit * Vector3(list[3 * i].get<double>(), list[3 * i + 1].get<double>(),
                        list[3 * i + 2].get<double>());
}

TEST_F(LinkPicture, IsAClosedSurface) {
  const Json picture = link_picture(result());
  const Json& corners = picture["triangles"];
  std::map<std::pair<int, int>, int> edges;
  for (std::size_t t = 0; t < corners.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k)
      ++edges[{corners[t + k].get<int>(), corners[t + (k + 1) % 3].get<int>()}];
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);  // the neighbour, turned around
  }
}

// The rigid tip moves as the compliance says: t + w x r.
TEST_F(LinkPicture, MovesTheLoadedInterfaceAsTheComplianceSays) {
  const Json picture = link_picture(result());
  const Matrix6 compliance = result().response.compliance();
  const double unit = picture["point_unit"];
  std::set<std::size_t> tip;
  for (std::size_t t = 0; t < picture["of_interface"].size(); ++t)
    if (picture["of_interface"][t] == 2)
      for (std::size_t k = 0; k < 3; ++k)
        tip.insert(picture["triangles"][3 * t + k].get<std::size_t>());
  ASSERT_GE(tip.size(), 4u);
  for (std::size_t load = 0; load < 6; ++load) {
    const Json& shape = picture["shapes"][load];
    const auto column = static_cast<Eigen::Index>(load);
    const Vector3 t = compliance.block<3, 1>(0, column), w = compliance.block<3, 1>(3, column);
    for (const std::size_t i : tip) {
      const Vector3 r = entry(picture["points"], i, unit) - result().interfaces[1].point;
      const Vector3 moved = entry(shape["displacements"], i, shape["unit"]);
      // Both are whole numbers of their units: r is half a unit off in each direction, at most.
      const double rounding = unit * w.norm() + shape["unit"].get<double>();
      EXPECT_LT((moved - (t + w.cross(r))).norm(), rounding + 1e-6 * t.norm()) << shape["load"];
    }
  }
}

// Each triangle of a flat end lies in the plane that its selector names.
TEST_F(LinkPicture, NamesTheFaceOfEveryTriangle) {
  const Json picture = link_picture(result());
  const double unit = picture["point_unit"];
  ASSERT_EQ(picture["of_face"].size(), picture["of_interface"].size());
  std::set<std::string> ends;
  for (std::size_t t = 0; t < picture["of_face"].size(); ++t) {
    if (picture["of_interface"][t] == 0) continue;
    ASSERT_GE(picture["of_face"][t], 0);
    const std::string selector = picture["faces"][picture["of_face"][t].get<std::size_t>()];
    double x = 0;
    ASSERT_EQ(std::sscanf(selector.c_str(), "plane: {point: [%lf,", &x), 1) << selector;
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(entry(picture["points"], picture["triangles"][3 * t + k], unit).x(),
                  x * result_unit, 2 * unit);
    ends.insert(selector);
  }
  EXPECT_EQ(ends.size(), 2u);
}

TEST_F(LinkPicture, KeepsToTheNumberOfPoints) {
  const Json picture = link_picture(result(), 60);
  const std::size_t count = picture["points"].size() / 3;
  EXPECT_LE(count, 60u);
  EXPECT_GE(count, 8u);
  EXPECT_EQ(picture["triangles"].size(), 3 * picture["of_interface"].size());
  for (const Json& corner : picture["triangles"]) EXPECT_LT(corner.get<std::size_t>(), count);
  for (const Json& shape : picture["shapes"]) EXPECT_EQ(shape["displacements"].size(), 3 * count);
}

// A box without one facet: the three that lie beside the hole, and no others.
TEST(SurfacePicture, ShowsTheFacetsOfEveryDefect) {
  fea::SurfaceMesh box = fea::box_surface({0, 0, 0}, {0.04, 0.03, 0.02});
  const fea::Triangle gone = box.triangles.back();
  box.triangles.pop_back();
  const Json picture = surface_picture(box, fea::check_surface(box, 1e-7), {"mm", 1e-3});
  ASSERT_EQ(picture["defects"], Json::array({"open edge"}));
  ASSERT_EQ(picture["of_defect"].size(), box.triangles.size());
  for (std::size_t t = 0; t < box.triangles.size(); ++t) {
    const auto shared = std::count_if(gone.begin(), gone.end(), [&](int corner) {
      return std::find(box.triangles[t].begin(), box.triangles[t].end(), corner) !=
             box.triangles[t].end();
    });
    EXPECT_EQ(picture["of_defect"][t], shared == 2 ? 0 : -1) << t;
  }
}

}  // namespace
}  // namespace kinetostat::report::link_picture_test
