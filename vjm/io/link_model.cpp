#include "kinetostat/vjm/io/link_model.h"

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_builder.h"

namespace kinetostat::vjm {
namespace {

using spatial::Pose;
using spatial::Vector3;

// A passive joint along or about each axis, or a screw, in a frame whose x axis it is.
void append_free_motions(const LinkPart& part, ChainBuilder& chain, const std::string& name) {
  int number = 0;
  for (const ScrewMotion& motion : part.free_motions) {
    const Pose axis(
        Eigen::Quaterniond::FromTwoVectors(Vector3::UnitX(), motion.direction).toRotationMatrix(),
        motion.is_translation ? Vector3::Zero() : motion.point);
    chain.offset(axis);
    const std::string joint = fmt::format("{}.free{}", name, ++number);
    chain.passive(joint, motion.is_translation ? Motion::tx : Motion::rx);
    if (motion.pitch != 0) chain.coupled(joint, Motion::tx, motion.pitch);
    chain.offset(axis.inverse());
  }
}

}  // namespace

void LinkModel::append_to(ChainBuilder& chain, const std::string& name) const {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::string part_name = parts.size() == 1 ? name : fmt::format("{}.{}", name, i + 1);
    const Pose& offset = parts[i].offset;
    const double share = mass ? 0.5 * mass->mass / static_cast<double>(parts.size()) : 0;
    const Vector3 center = mass ? mass->center : Vector3::Zero();
    const Vector3 third = offset.position() / 3;
    const spatial::Matrix3 half =
        mass ? spatial::Matrix3(0.5 * mass->inertia / static_cast<double>(parts.size()))
             : spatial::Matrix3(spatial::Matrix3::Zero());
    const bool travels = parts[i].travels;
    if (travels) append_free_motions(parts[i], chain, part_name);
    if (share > 0) chain.mass(part_name + ".mass1", share, center - third, name, half);
    if (parts[i].compliance) {
      chain.link(part_name, offset, *parts[i].compliance);
    } else {
      chain.offset(offset);
    }
    if (!travels) append_free_motions(parts[i], chain, part_name);
    if (share > 0)
      chain.mass(part_name + ".mass2", share, offset.inverse() * Vector3(center + third), name,
                 offset.rotation().transpose() * half * offset.rotation());
  }
}

}  // namespace kinetostat::vjm
