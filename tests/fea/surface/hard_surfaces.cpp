#include "fea/surface/hard_surfaces.h"

#include <cmath>
#include <functional>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "fea/surface/solid_shapes.h"
#include "fea/surface/surface_spoiling.h"

namespace kinetostat::fea::hard {
namespace {

double diagonal(const SurfaceMesh& mesh) { return bounding_box(mesh.points).diagonal().norm(); }

// -- Parts ----------------------------------------------------------------------------------------

// A cover: a bent, slightly elliptical tube of varying radius with a thin wall.
SurfaceMesh arm_shell(double length, double radius, double wall, int around, int along) {
  const auto ring = [=](double inset) {
    return [=](double s, double angle) {
      const double swell = 1 + 0.25 * std::sin(M_PI * s) - 0.1 * s;
      const double r = radius * swell - inset;
      const double bump = 1 + 0.04 * std::cos(3 * angle) * std::sin(M_PI * s);
      return Vector3(length * s, 0.08 * length * std::sin(M_PI * s) + r * bump * std::cos(angle),
                     0.8 * r * bump * std::sin(angle));
    };
  };
  return lofted_shell(ring(0), ring(wall), around, along);
}

// A box with thin walls, `ribs` across it and one opening in its lid.
SurfaceMesh housing(const Vector3& size, double wall, int ribs) {
  std::vector<double> x{0, wall},
      y{0, wall, 0.3 * size.y(), 0.7 * size.y(), size.y() - wall, size.y()},
      z{0, wall, size.z() - wall, size.z()};
  for (int i = 1; i <= ribs; ++i) {
    const double at = size.x() * i / (ribs + 1);
    x.insert(x.end(), {at - wall / 2, at + wall / 2});
  }
  x.insert(x.end(), {size.x() - wall, size.x()});
  const double first_bay = 0.95 * size.x() / (ribs + 1);
  return cells(x, y, z, [=](const Vector3& p) {
    const bool in_rib = std::fmod(p.x() + wall / 2, size.x() / (ribs + 1)) < wall;
    const bool in_end = p.x() < wall || p.x() > size.x() - wall;
    const bool in_side = p.y() < wall || p.y() > size.y() - wall;
    const bool in_lid = p.z() < wall || p.z() > size.z() - wall;
    const bool in_opening = p.z() > size.z() - wall && p.x() < first_bay && !in_end && !in_rib &&
                            p.y() > 0.3 * size.y() && p.y() < 0.7 * size.y();
    return in_end || in_side || (in_lid && !in_opening) || (ribs > 0 && in_rib);
  });
}

SurfaceMesh plate(double length, double width, double thick, int holes, int sides, int layers = 1) {
  std::vector<Outline> bores;
  for (int i = 0; i < holes; ++i)
    bores.push_back(circle({length * (i + 1) / (holes + 1), width * (i % 2 == 0 ? 0.35 : 0.65)},
                           0.25 * std::min(width, length / (holes + 1)), sides));
  return prism(rounded_rectangle({0, 0}, {length, width}, 0.2 * width, std::max(2, sides / 4)),
               bores, thick, layers);
}

// Sheet metal bent `folds` times, its ends square to x.
SurfaceMesh sheet(double length, double depth, double thick, int folds, double width, int layers) {
  std::vector<Point2> middle{{0, 0}};
  for (int i = 0; i < folds; ++i) {
    const double x = length * (i + 1) / (folds + 1), y = i % 2 == 0 ? 0 : depth;
    middle.emplace_back(x - 0.02 * length, y);
    middle.emplace_back(x + 0.02 * length, depth - y);
  }
  middle.emplace_back(length, folds % 2 == 0 ? 0 : depth);
  return prism(strip(middle, thick), {}, width, layers);
}

// A shaft with collars and a bore, with rounded shoulders of `round` chords.
SurfaceMesh shaft(double length, double radius, double bore, int collars, int round, int sides) {
  Outline profile{{0, bore}, {length, bore}, {length, radius}};
  for (int i = collars; i-- > 0;) {
    const double at = length * (i + 0.5) / collars, half = 0.15 * length / collars;
    const double fillet = 0.1 * radius;
    for (int k = 0; k <= round; ++k) {
      const double a = M_PI / 2 * k / round;
      profile.emplace_back(at + half + fillet * (1 - std::sin(a)),
                           radius + fillet * (1 - std::cos(a)));
    }
    profile.emplace_back(at + half, 1.4 * radius);
    profile.emplace_back(at - half, 1.4 * radius);
    for (int k = round; k >= 0; --k) {
      const double a = M_PI / 2 * k / round;
      profile.emplace_back(at - half - fillet * (1 - std::sin(a)),
                           radius + fillet * (1 - std::cos(a)));
    }
  }
  profile.emplace_back(0, radius);
  return revolved(profile, sides);
}

Box box(double x0, double y0, double z0, double x1, double y1, double z1) {
  return {Vector3(x0, y0, z0), Vector3(x1, y1, z1)};
}

// -- Sound, and hard ------------------------------------------------------------------------------

struct Pair {
  SurfaceMesh mesh, clean;
};

Pair hollow_shell(int i, Random&) {
  const double wall[] = {3, 2.5, 2, 1.5, 1.2, 1};
  const std::size_t facets[] = {600, 1200, 2000, 3000, 4500, 6000};
  const SurfaceMesh fine = arm_shell(220 + 40 * i, 45 + 4 * i, wall[i], 96, 48);
  return {decimated(fine, facets[i], 0.7 * wall[i]), fine};
}

Pair slivers(int i, Random& random) {
  const SurfaceMesh clean = i % 2 == 0 ? plate(200, 60, 8, 3, 24, 2) : shaft(240, 18, 9, 2, 4, 32);
  const double part[] = {1e-2, 5e-3, 1e-3, 2e-3, 5e-4, 1e-3};
  SurfaceMesh mesh = clean;
  add_slivers(mesh, 60 + 60 * i, part[i], random);
  add_needles(mesh, 30 + 30 * i, part[i], random);
  return {mesh, clean};
}

Pair thin_wall(int i, Random& random) {
  const double wall[] = {2, 1.5, 1, 0.8, 0.6, 0.5};
  const SurfaceMesh clean =
      i % 2 == 0 ? housing({240, 80, 60}, wall[i], 2 + i) : sheet(200, 30, wall[i], 3 + i, 60, 4);
  SurfaceMesh mesh = i % 2 == 0 ? subdivided(clean) : clean;
  add_needles(mesh, 40 * i, 1e-2, random);
  return {mesh, clean};
}

// Slivers folded over within the tolerance, so that coplanar facets overlap.
Pair coplanar_overlap(int i, Random& random) {
  const SurfaceMesh clean =
      i % 2 == 0 ? subdivided(housing({160, 70, 50}, 4, 1)) : plate(180, 50, 6, 2, 20, 1);
  SurfaceMesh mesh = clean;
  const double size[] = {3e-8, 1e-7, 1e-7, 2e-7, 3e-7, 4e-7};
  add_folds(mesh, 20 + 30 * i, size[i] * diagonal(mesh), random);
  return {mesh, clean};
}

// Hundreds of small shells: blowholes of a casting, each a cavity.
Pair small_components(int i, Random& random) {
  const SurfaceMesh clean = plate(160, 50, 24, 0, 24, 1);
  SurfaceMesh mesh = clean;
  const int count = 20 + 36 * i;
  for (int k = 0; k < count; ++k) {
    const double x = 10 + 140 * (k + 0.5) / count;
    const Vector3 centre(x, 4 + 5 * (k % 2) + random.uniform(0, 0.5),
                         4 + 16 * random.uniform(0, 1));
    append(mesh, inverted(icosahedron(centre, std::min(0.9, 30.0 / count))));
  }
  return {mesh, clean};
}

Pair needles(int i, Random&) {
  const int sides[] = {120, 200, 180, 360, 240, 700};
  if (i % 2 == 0) return {shaft(300, 20, 14, 1, 2, sides[i]), shaft(300, 20, 14, 1, 2, 64)};
  const auto cup = [&](int n) {  // fans at the axis, a cavity within
    SurfaceMesh mesh = revolved({{0, 0}, {200, 0}, {200, 25}, {0, 25}}, n);
    append(mesh, inverted(revolved({{5, 0}, {195, 0}, {195, 22}, {5, 22}}, n)));
    return mesh;
  };
  return {cup(sides[i]), cup(64)};
}

// Flat faces whose corners are off by 1e-7 of the part.
Pair flat_noise(int i, Random& random) {
  const SurfaceMesh clean =
      i % 2 == 0 ? housing({200, 80, 60}, 5, i) : plate(200, 60, 10, 3, 24, 3);
  const double size[] = {3e-8, 1e-7, 1e-7, 2e-7, 3e-7, 5e-7};
  SurfaceMesh mesh = i == 1 || i == 3 ? clean : subdivided(clean);
  if (i > 2) add_needles(mesh, 50, 1e-2, random);
  add_noise(mesh, size[i] * diagonal(mesh), random);
  return {mesh, clean};
}

Pair cad_part(int i, Random&) {
  const int sides[] = {24, 36, 48, 40, 96, 48};
  if (i % 2 == 0)
    return {plate(220, 80, 10 - i, 3 + i, sides[i], 1), plate(220, 80, 10 - i, 3 + i, 24, 1)};
  return {shaft(260, 20, 12, 2 + i / 2, 2 + i, sides[i]), shaft(260, 20, 12, 2 + i / 2, 4, 36)};
}

// A ribbed cover, bulged, then decimated hard: facets of very different size meet at thin ribs.
Pair decimated_cover(int i, Random& random) {
  const double wall = 4 - 0.4 * i;
  const auto bulge = [](SurfaceMesh mesh) {
    for (Vector3& p : mesh.points) {
      const double s = std::sin(M_PI * std::clamp(p.x() / 240, 0.0, 1.0));
      p.y() += 0.1 * s * (p.y() - 40);
      p.z() += 12 * s;
    }
    return mesh;
  };
  const SurfaceMesh fine = subdivided(subdivided(subdivided(housing({240, 80, 60}, wall, 3))));
  const SurfaceMesh clean = bulge(subdivided(subdivided(housing({240, 80, 60}, wall, 3))));
  SurfaceMesh rough = bulge(fine);
  add_noise(rough, 1e-7 * diagonal(rough), random);
  const std::size_t facets[] = {5000, 4000, 3000, 2200, 1500, 1100};
  return {decimated(rough, facets[i], 0.5 * wall), clean};
}

// Thin wedges: two faces of a sharp edge, and fillets that run out into a flat face.
Pair sharp_edge(int i, Random& random) {
  const double degrees[] = {8, 5, 3, 2, 1, 0.5};
  const double rise = std::tan(degrees[i] * M_PI / 180);
  Outline outline{{0, 0}, {200, 0}, {200, 20}};
  for (int k = 4; k-- > 0;) {  // notches that end in a sharp root, on a block 20 high
    const double at = 20 + 45 * k, deep = 10, wide = std::max(0.2, deep * rise);
    outline.insert(outline.end(), {{at + wide, 20}, {at + wide / 2, 20 - deep}, {at, 20}});
  }
  outline.emplace_back(0, 20);
  SurfaceMesh clean = prism(outline, {}, 30, 1);
  SurfaceMesh fin = clean;
  add_slivers(fin, 10 * i, 1e-3, random);
  return {fin, clean};
}

// -- Broken ---------------------------------------------------------------------------------------

SurfaceMesh base(int i) {
  switch (i) {
    case 0:
      return plate(200, 60, 8, 3, 24, 2);
    case 1:
      return shaft(240, 18, 9, 2, 3, 28);
    case 2:
      return subdivided(housing({200, 70, 50}, 4, 2));
    case 3:
      return decimated(arm_shell(240, 45, 4, 64, 32), 2500, 0.2);
    case 4:
      return sheet(180, 30, 3, 3, 50, 3);
    default:
      return subdivided(plate(160, 50, 20, 1, 16, 1));
  }
}

Pair open_edges(int i, Random& random) {
  const SurfaceMesh clean = base(i);
  return {soup(clean, 2e-5 * diagonal(clean), random), clean};
}

Pair missing_facets(int i, Random& random) {
  const SurfaceMesh clean = i < 2 ? subdivided(base(i)) : base(i == 4 ? 3 : i);
  SurfaceMesh mesh = clean;
  remove_facets(mesh, 3 + 2 * i, i == 4 ? 2 : i % 2, random);
  return {mesh, clean};
}

// Walls decimated until they cross, and points pushed through what lies behind them.
Pair self_intersection(int i, Random& random) {
  if (i % 2 == 0) {
    const double wall = 1.2 - 0.2 * i;
    const SurfaceMesh fine = arm_shell(240, 45, wall, 96, 48);
    return {decimated(fine, static_cast<std::size_t>(1200 + 300 * i), 4 * wall), fine};
  }
  const SurfaceMesh clean = subdivided(i == 1 ? base(3) : base(2));
  SurfaceMesh mesh = clean;
  push_points(mesh, 2 + i, 6, random);
  return {mesh, clean};
}

Pair overlapping_bodies(int i, Random&) {
  if (i % 2 == 0) {
    std::vector<Box> boxes{box(0, 0, 0, 200, 40, 10)};
    for (int k = 0; k < 2 + i; ++k) {
      const double x = 15.3 + 170.0 * k / (2 + i);
      boxes.push_back(box(x, 5.1, 3.7, x + 9.1, 34.3, 30.9));
    }
    if (i > 0) boxes.push_back(box(10.7, 17.9, 5.3, 190.1, 22.3, 24.1));
    SurfaceMesh mesh;
    for (const Box& b : boxes) append(mesh, box_surface(b.min(), b.max()));
    return {mesh, union_of(boxes)};
  }
  const int collars = 1 + i, sides = 24 + 8 * i;
  const double bore = 8, radius = 15;
  SurfaceMesh mesh = revolved({{0, bore}, {200, bore}, {200, radius}, {0, radius}}, sides);
  Outline envelope{{0, bore}, {200, bore}, {200, radius}};
  for (int k = collars; k-- > 0;) {
    const double a = 20 + 160.0 * k / collars, b = a + 60.0 / collars;
    append(mesh, revolved({{a, 11}, {b, 11}, {b, 24}, {a, 24}}, sides));
    envelope.insert(envelope.end(), {{b, radius}, {b, 24}, {a, 24}, {a, radius}});
  }
  envelope.emplace_back(0, radius);
  return {mesh, revolved(envelope, sides)};
}

Pair flipped_facets(int i, Random& random) {
  const SurfaceMesh clean = base(i);
  SurfaceMesh mesh = clean;
  flip_facets(mesh, 0.1 + 0.08 * i, random);
  return {i % 2 == 0 ? mesh : soup(mesh, 1e-6 * diagonal(mesh), random), clean};
}

Pair repeated_facets(int i, Random& random) {
  const SurfaceMesh clean = base(i);
  SurfaceMesh mesh = clean;
  repeat_facets(mesh, 0.05 + 0.15 * i, random);
  return {i % 2 == 0 ? mesh : soup(mesh, 3e-6 * diagonal(mesh), random), clean};
}

Pair t_junctions(int i, Random& random) {
  const SurfaceMesh clean = base(i);
  SurfaceMesh mesh = clean;
  add_t_junctions(mesh, 10 + 25 * i, random);
  if (i > 2) add_noise(mesh, 1e-6 * diagonal(mesh), random);
  return {mesh, clean};
}

Pair cracks(int i, Random&) {
  const SurfaceMesh clean = base(i);
  SurfaceMesh mesh = clean;
  const double gap[] = {2e-5, 5e-5, 1e-4, 3e-4, 1e-3, 2e-3};
  add_crack(mesh, 71, gap[i] * diagonal(mesh));
  add_crack(mesh, 123, gap[i] * diagonal(mesh));
  return {mesh, clean};
}

// Seams of several sizes, holes, facets twice and turned over, all at once.
Pair tiny_gaps(int i, Random& random) {
  const SurfaceMesh clean = base(i);
  SurfaceMesh mesh = clean;
  repeat_facets(mesh, 0.03, random);
  add_t_junctions(mesh, 5 * i, random);
  const double size[] = {3e-6, 1e-5, 2e-5, 3e-5, 4e-5, 5e-5};
  mesh = soup(mesh, size[i] * diagonal(mesh), random);
  flip_facets(mesh, 0.1, random);
  return {mesh, clean};
}

// Bodies that touch in parts of a plane, as assemblies are exported.
Pair touching_bodies(int i, Random&) {
  std::vector<Box> boxes{box(0, 0, 0, 200, 40, 10)};
  for (int k = 0; k <= i; ++k) {
    const double x = 20 + 160.0 * k / (i + 1);
    boxes.push_back(box(x, 5, 10, x + 12, k % 2 == 0 ? 35 : 40, 30));  // stands on the first
  }
  if (i > 1) boxes.push_back(box(20, 10, 30, 180, 30, 36));
  if (i > 2) boxes.push_back(box(200, 0, 0, 220, 40, 25));  // a whole side of one is part of it
  SurfaceMesh mesh;
  for (const Box& b : boxes) append(mesh, box_surface(b.min(), b.max()));
  return {mesh, union_of(boxes)};
}

struct Family {
  const char* name;
  bool is_broken;
  Pair (*make)(int variant, Random& random);
};

constexpr Family all[] = {{"hollow_shell", false, hollow_shell},
                          {"slivers", false, slivers},
                          {"thin_wall", false, thin_wall},
                          {"coplanar_overlap", false, coplanar_overlap},
                          {"small_components", false, small_components},
                          {"needles", false, needles},
                          {"flat_noise", false, flat_noise},
                          {"cad_part", false, cad_part},
                          {"decimated_cover", false, decimated_cover},
                          {"sharp_edge", false, sharp_edge},
                          {"open_edges", true, open_edges},
                          {"missing_facets", true, missing_facets},
                          {"self_intersection", true, self_intersection},
                          {"overlapping_bodies", true, overlapping_bodies},
                          {"flipped_facets", true, flipped_facets},
                          {"repeated_facets", true, repeated_facets},
                          {"t_junctions", true, t_junctions},
                          {"cracks", true, cracks},
                          {"tiny_gaps", true, tiny_gaps},
                          {"touching_bodies", true, touching_bodies}};

}  // namespace

const std::vector<std::string>& families() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Family& family : all) list.emplace_back(family.name);
    return list;
  }();
  return names;
}

HardSurface hard_surface(const std::string& name, int variant) {
  std::uint64_t seed = static_cast<std::uint64_t>(variant);
  for (const Family& family : all) {
    seed += 100;
    if (name != family.name) continue;
    Random random(seed);
    Pair pair = family.make(variant, random);
    round_to_single(pair.mesh);
    const Box bounds = bounding_box(pair.clean.points);
    const double reach = 3e-3 * bounds.diagonal().norm();
    Box low = bounds, high = bounds;
    for (Box* side : {&low, &high}) {
      side->min().array() -= reach;
      side->max().array() += reach;
    }
    low.max().x() = bounds.min().x() + reach;
    high.min().x() = bounds.max().x() - reach;
    return {name, family.is_broken, std::move(pair.mesh), std::move(pair.clean), low, high};
  }
  throw std::invalid_argument("no family of hard surfaces is called " + name);
}

}  // namespace kinetostat::fea::hard
