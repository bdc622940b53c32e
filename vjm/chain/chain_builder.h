// Builds chains, element by element.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "kinetostat/spatial/stiffness.h"
#include "kinetostat/vjm/chain/chain.h"

namespace kinetostat::vjm {

/// From base to end in the order of JAMRIS09 eq. 1:
///
///     const Chain chain = ChainBuilder("x", base)
///                             .actuator("rho", Motion::tx, 1e8)
///                             .link("foot", offset, compliance)
///                             .passive("u1.Rz", Motion::rz)
///                             .build();
///
/// Everything is given in the local frame that the elements before have led to. All throw
/// std::invalid_argument on non-positive stiffness, names used twice and unknown names.
class ChainBuilder {
 public:
  explicit ChainBuilder(std::string name, const spatial::Pose& base = {});
  /// Goes on at the end of a chain.
  explicit ChainBuilder(Chain chain);

  Chain build() const { return chain_; }
  /// What has been built so far.
  const Chain& so_far() const { return chain_; }

  /// A constant offset: a rigid link, a flange, a tool.
  ChainBuilder& offset(const spatial::Pose& pose);
  /// An actuated joint. Stiffness [N/m or N m/rad]; none: it holds its command rigidly.
  ChainBuilder& actuator(const std::string& name, Motion motion, std::optional<double> stiffness,
                         double home = 0);
  /// Where the command of an actuated joint may lie [m or rad].
  ChainBuilder& range(const std::string& name, double least, double largest);
  /// A perfect passive joint.
  ChainBuilder& passive(const std::string& name, Motion motion, double home = 0);
  /// A passive joint with a spring that is relaxed at `rest` [m or rad] (MMT11 eq. 2).
  ChainBuilder& passive(const std::string& name, Motion motion, double stiffness, double rest,
                        double home);
  /// A further joint that moves by `factor` times the coordinate of an earlier actuated or passive
  /// one. One may turn and the other slide, as in a screw or a rack: the factor is then in m/rad,
  /// or in rad/m.
  ChainBuilder& coupled(const std::string& name, Motion motion, double factor);
  /// A flexible link: `offset` to its end, then the virtual joint Tx Ty Tz Rx Ry Rz there
  /// (JAMRIS09 eq. 1). The compliance is taken at the link's end in the axes of the end frame; its
  /// own frame() is ignored: bring it there with Compliance6::in.
  ChainBuilder& link(const std::string& name, const spatial::Pose& offset,
                     const spatial::Compliance6& compliance);

  /// The same virtual joint without a spring: what holds it is in no chain (ElasticBody).
  ChainBuilder& elastic(const std::string& name, const spatial::Pose& offset);

  /// A geometric error: an offset that the built chain has and the nominal one has not. Postures
  /// are found for the nominal chain (without_errors()).
  ChainBuilder& error(const spatial::Pose& pose);
  /// A further law on an earlier actuated or passive joint.
  ChainBuilder& law(const std::string& name, std::shared_ptr<const CoordinateLaw> law);
  /// A named point here, for loads; throws when the name is taken.
  ChainBuilder& node(const std::string& name,
                     const spatial::Vector3& position = spatial::Vector3::Zero());
  /// A mass here, at a position in the current frame. `element`: the link that it is a part of;
  /// empty: it stands alone, under its own name. `inertia` [kg m^2] as PointMass::inertia, in the
  /// axes of the current frame.
  ChainBuilder& mass(const std::string& name, double mass, const spatial::Vector3& position,
                     const std::string& element = {},
                     const spatial::Matrix3& inertia = spatial::Matrix3::Zero());
  /// The chain ends here; `to_reference` leads on to the reference point of the body that it ends
  /// on. Errors and displacements of the "end" are those of the chain, in front of that.
  ChainBuilder& attach(const spatial::Pose& to_reference);

 private:
  Chain chain_;
};

}  // namespace kinetostat::vjm
