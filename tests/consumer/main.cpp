// Uses something of every module, so that every library and its dependencies must link.
#include <cmath>
#include <cstdio>
#include <kinetostat/calibration/statistics/goodness_of_fit.h>
#include <kinetostat/fea/elasticity/elasticity.h>
#include <kinetostat/io/yaml.h>
#include <kinetostat/vjm/chain/beam.h>

// The tip deflection of a clamped bar, once from its 6x6 compliance and once by hand.
int main() {
  using namespace kinetostat;
  const io::YamlNode file =
      io::parse_yaml("units: {length: mm, force: N}\nspan: 310\nload: 2\n", "example.yaml");
  const spatial::UnitSystem units = io::read_units(file.at("units"));
  const double span = file.at("span").positive(spatial::dimension::length, units);
  const double load = file.at("load").positive(spatial::dimension::force, units);

  const vjm::Material steel{.young_modulus = 210e9, .shear_modulus = 80e9, .density = 7850};
  const vjm::Section section = vjm::Section::rectangle(0.020, 0.012, steel.poisson_ratio());
  const spatial::Compliance6 tip =
      vjm::beam_compliance(span, section, steel, vjm::BeamTheory::euler_bernoulli);
  const spatial::Wrench force{{0, load, 0}, {0, 0, 0}, tip.frame()};
  const double deflection = (tip * force).translation.y();

  const double by_hand = load * std::pow(span, 3) / (3 * 210e9 * section.second_moment_z);
  std::printf("deflection %g um, by hand %g um\n", 1e6 * deflection, 1e6 * by_hand);

  // Half of all sound models exceed the median of chi-square with two degrees of freedom, 2 ln 2.
  const double half = calibration::chi_square_test(2 * std::log(2.0), 2).p_value;
  std::printf("p value of the median %g\n", half);

  // An element resists no translation.
  const fea::ElementStiffness<10> element = fea::stiffness_tet10(
      {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, fea::Material(210e9, 0.3));
  Eigen::Matrix<double, 30, 1> along_x = Eigen::Matrix<double, 30, 1>::Zero();
  for (int node = 0; node < 10; ++node) along_x[3 * node] = 1;
  const double resistance = (element * along_x).norm();
  std::printf("resistance to translation %g N/m\n", resistance);

  return std::abs(deflection - by_hand) < 1e-12 * by_hand && std::abs(half - 0.5) < 1e-12 &&
                 resistance < 1e-12 * element.norm()
             ? 0
             : 1;
}
