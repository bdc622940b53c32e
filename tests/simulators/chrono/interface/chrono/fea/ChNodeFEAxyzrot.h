// Declarations of Chrono's interface: a node of six coordinates, translations in absolute axes and
// rotations in its own.
#pragma once

#include "chrono/physics/ChSystem.h"

namespace chrono::fea {

class ChNodeFEAxyzrot {
 public:
  explicit ChNodeFEAxyzrot(ChFrame<> frame = ChFrame<>()) : frame_(std::move(frame)) {}

  const ChFrame<>& Frame() const { return frame_; }
  void SetMass(double mass) { mass_ = mass; }
  double GetMass() const { return mass_; }
  ChMatrix33<>& GetInertia() { return inertia_; }

 private:
  ChFrame<> frame_;
  double mass_ = 1;
  ChMatrix33<> inertia_ = ChMatrix33<>::Identity();
};

}  // namespace chrono::fea
