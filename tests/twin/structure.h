// Bodies, springs between them, and their equilibrium with large displacements: the mechanics of
// the twin. Beams are chains of bodies with a geometrically exact element between each two (one
// point of integration, in the frame midway between its ends; Simo, Comput. Methods Appl. Mech.
// Eng. 49 (1985) 55); joints are the same element with stiff directions instead of constraints.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/SparseCholesky>

#include "joint_law.h"
#include "so3.h"

namespace twin {

constexpr int ground = -1;

/// A frame on a body (or on the ground, in base axes).
struct Mark {
  int body = ground;
  Pose at;  // in the axes of the body
};

/// Elastic energy 1/2 e'K e of e = [E'(p_b - p_a); vector of R_a'R_b] - rest, E midway between the
/// marks [m; rad]. A law replaces K on one axis, of e in that axis.
struct Coupling {
  Mark a, b;
  Vector6 rest = Vector6::Zero();
  Matrix6 stiffness = Matrix6::Zero();
  int axis = -1;
  JointLawPointer law = nullptr;
  int group = -1;  // of springs whose stiffness scatters together
};

/// A spring along the line between two points: force k (length - free_length).
struct Strut {
  Mark a, b;
  double k = 0, free_length = 0;
};

/// A force [N] and moment [N m] in base axes that stay as they are while their point moves.
struct DeadLoad {
  Mark at;
  Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
};

class Structure {
 public:
  /// Returns its number. `mass` [kg] at its origin.
  int add_body(const Pose& pose, double mass = 0);
  void add_mass(int body, double mass) { mass_[static_cast<std::size_t>(body)] += mass; }
  int add(Coupling coupling);
  void add(Strut strut) { struts_.push_back(strut); }
  void gravity(const Vector3& acceleration) { gravity_ = acceleration; }

  /// The mark on a body that now stands at `pose` of the base.
  Mark mark(int body, const Pose& pose) const;
  Pose pose_of(const Mark& mark) const;
  Coupling& coupling(int number) { return couplings_[static_cast<std::size_t>(number)]; }
  const Coupling& coupling(int number) const {
    return couplings_[static_cast<std::size_t>(number)];
  }
  std::vector<Coupling>& couplings() { return couplings_; }
  int bodies() const { return static_cast<int>(poses_.size()); }

  /// Moves the bodies into equilibrium, from where they are. False when Newton's method fails. It
  /// ends where steps are below 1e-8 and no longer shrink; `more` steps bring it to rounding.
  bool settle(const std::vector<DeadLoad>& loads, int more = 0);
  /// Joint laws take note of where they are.
  void accept(double seconds);
  /// Change [translation; rotation] of a mark with the logarithm of each group's stiffness, one
  /// column a group, about the equilibrium of the last settle().
  Eigen::MatrixXd sensitivity(const Mark& mark, int groups) const;
  /// Motion [translation; rotation] of a mark under unit forces along x, y, z, likewise.
  Eigen::Matrix<double, 6, 3> compliance(const Mark& mark) const;
  /// Elastic and potential energy of a structure without joint laws and moments.
  double energy(const std::vector<DeadLoad>& loads) const;
  /// Derivative of the energy by translation and spin of each body.
  Eigen::VectorXd gradient(const std::vector<DeadLoad>& loads) const;
  void move(const Eigen::VectorXd& step);

 private:
  struct Local;
  using Tangent = Eigen::SparseMatrix<double>;
  Local local(const Coupling& coupling) const;
  std::vector<Local> locals() const;
  Eigen::VectorXd gradient(const std::vector<DeadLoad>& loads,
                           const std::vector<Local>& couplings) const;
  Tangent tangent(const std::vector<DeadLoad>& loads, const std::vector<Local>& couplings) const;
  Eigen::VectorXd group_force(int group) const;
  Vector6 motion_of(const Mark& mark, const Eigen::VectorXd& change) const;
  std::vector<DeadLoad> with_weights(const std::vector<DeadLoad>& loads) const;

  std::vector<Pose> poses_;
  std::vector<double> mass_;
  std::vector<Coupling> couplings_;
  std::vector<Strut> struts_;
  Vector3 gravity_ = Vector3::Zero();
  bool search(const std::vector<DeadLoad>& loads);
  using Factor = Eigen::SimplicialLDLT<Tangent>;
  std::shared_ptr<const Factor> factor_;  // of the last iteration
};

}  // namespace twin
