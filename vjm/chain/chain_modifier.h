// What effects change in a chain that is built.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "kinetostat/vjm/chain/chain.h"

namespace kinetostat::vjm {

/// `element` is "base", "end", a joint or a link; all throw std::invalid_argument for another name.
class ChainModifier {
 public:
  explicit ChainModifier(Chain chain) : chain_(std::move(chain)) {}
  /// Takes all changes back. `original`: the chain that it started from.
  void take_back(const Chain& original);

  /// The chain with all changes so far.
  const Chain& chain() const& { return chain_; }
  Chain chain() && { return std::move(chain_); }

  /// A further law on an actuated or passive joint.
  void add_law(const std::string& joint, std::shared_ptr<const CoordinateLaw> law);
  /// Multiplies a spring's stiffness; compliances in series with it stay what they are. Throws
  /// std::invalid_argument for an unknown spring, or a factor that is not positive.
  void scale_spring(const std::string& spring, double factor);
  /// The stiffness that a spring of the name has in another chain. Throws std::invalid_argument for
  /// an unknown spring.
  void take_spring(const std::string& spring, const Chain& from);
  /// A compliance in series with the spring of a joint; several add up.
  void add_series_compliance(const std::string& joint, double compliance);
  /// A spring of this compliance right behind an element, in its axes, named `name`; a second one
  /// of the name is in series with the first. Coordinates are appended, so that postures of the
  /// chain without it stay good. Where the compliance is lost in the rounding of the stiffest
  /// spring, of the chain or of those beside it, nothing is inserted.
  void add_compliance_behind(const std::string& element, const std::string& name, Motion motion,
                             double compliance);
  /// The stiffest springs that slide [N/m] and that turn [N m/rad] in chains beside this one.
  void stand_beside(double linear, double angular) { beside_ = {linear, angular}; }
  void add_displacement(const std::string& element, bool in_front,
                        const spatial::Vector6& displacement);
  void add_transmission_error(const TransmissionError& shift);
  /// A node at a pose in the frame of another node, or of the body right behind a joint, a link or
  /// "base"; at "end" a point of the body there, without axes.
  void add_node(const std::string& name, const std::string& place, const spatial::Pose& pose);
  /// A mass [kg] in the frame that the first `joints` joints lead to.
  void add_mass(const std::string& name, double mass, Eigen::Index joints,
                const spatial::Vector3& position);
  /// A mass [kg] on the body at the end, where that stands without displacements of the end. Throws
  /// std::invalid_argument when it is negative.
  void add_mass_at_end(const std::string& name, double mass, const spatial::Vector3& position);

 private:
  void insert_joint(Eigen::Index joints, Motion motion, Eigen::Index coordinate);
  void move_place(const ChainDisplacement& place, const spatial::Pose& change);
  ChainDisplacement& displacement_at(const std::string& element, bool in_front);

  double stiffest(bool turns) const;

  Chain chain_;
  std::array<double, 2> beside_ = {0, 0};  // linear, angular
  bool is_built_as_before_ = true;         // but for laws and transmission errors that were added
};

}  // namespace kinetostat::vjm
