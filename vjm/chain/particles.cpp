#include "kinetostat/vjm/chain/particles.h"

#include <cmath>
#include <string>

namespace kinetostat::vjm {
namespace {

bool ends_with(const std::string& text, const char* ending) {
  const std::string tail(ending);
  return text.size() > tail.size() &&
         text.compare(text.size() - tail.size(), tail.size(), tail) == 0;
}

// The two halves of a part of a link, as LinkModel::append_to names them.
bool are_halves(const Chain& chain, const PointMass& first, const PointMass& second) {
  return first.element == second.element && first.mass == second.mass &&
         ends_with(chain.nodes()[first.node].name, ".mass1") &&
         ends_with(chain.nodes()[second.node].name, ".mass2");
}

}  // namespace

std::vector<Particle> particles_of(const Chain& chain, const ChainKinematics& kinematics) {
  std::vector<Particle> particles;
  for (const PointMass& mass : chain.masses())
    particles.push_back({kinematics.nodes[mass.node], chain.nodes()[mass.node].joints, mass.mass});
  const double nearer = std::sqrt(3.0) / 2;  // L / sqrt(12) beside L / 3
  for (std::size_t k = 0; k + 1 < particles.size(); ++k) {
    if (!are_halves(chain, chain.masses()[k], chain.masses()[k + 1])) continue;
    const spatial::Vector3 center = (particles[k].position + particles[k + 1].position) / 2;
    for (Particle* half : {&particles[k], &particles[k + 1]})
      half->position = center + nearer * (half->position - center);
  }
  return particles;
}

}  // namespace kinetostat::vjm
