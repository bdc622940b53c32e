#include "joint_law.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace twin {
namespace {

class Linear : public JointLaw {
 public:
  explicit Linear(double k) : k_(k) {}
  Reaction at(double d) const override { return {k_ * d, k_}; }

 private:
  double k_;
};

class Hardening : public JointLaw {
 public:
  Hardening(double k, double d0) : k_(k), d0_(d0) {}
  Reaction at(double d) const override {
    // Beyond 20 d0 straight on, so that a far trial point does not overflow.
    const double u = std::clamp(d / d0_, -20., 20.), beyond = d - u * d0_;
    return {k_ * (d0_ * std::sinh(u) + std::cosh(u) * beyond), k_ * std::cosh(u)};
  }

 private:
  double k_, d0_;
};

double softplus(double x) { return std::max(x, 0.) + std::log1p(std::exp(-std::abs(x))); }
double logistic(double x) { return 0.5 * (1 + std::tanh(x / 2)); }

class Clearance : public JointLaw {
 public:
  Clearance(double k, double gap) : k_(k), gap_(gap), w_(0.15 * gap) {}
  Reaction at(double d) const override {
    const double up = (d - gap_) / w_, down = -(d + gap_) / w_;
    return {k_ * w_ * (softplus(up) - softplus(down)), k_ * (logistic(up) + logistic(down))};
  }

 private:
  double k_, gap_, w_;
};

class TwoSlopes : public JointLaw {
 public:
  TwoSlopes(double k, double ratio, double d1)
      : k_(k), more_(k * (ratio - 1)), d1_(d1), w_(d1 / 5) {}
  Reaction at(double d) const override {
    const double up = (d - d1_) / w_, down = -(d + d1_) / w_;
    return {k_ * d + more_ * w_ * (softplus(up) - softplus(down)),
            k_ + more_ * (logistic(up) + logistic(down))};
  }

 private:
  double k_, more_, d1_, w_;
};

class Lifting : public JointLaw {
 public:
  Lifting(double k, double looser, double d1)
      : k_(k), more_(k / (1 + looser) - k), d1_(d1), w_(d1 / 5) {}
  Reaction at(double d) const override {
    return {k_ * d + more_ * w_ * (softplus((d - d1_) / w_) - softplus(-d1_ / w_)),
            k_ + more_ * logistic((d - d1_) / w_)};
  }

 private:
  double k_, more_, d1_, w_;
};

class Creep : public JointLaw {
 public:
  Creep(double k, double c, double tau) : k_(k), c_(c / 2), tau_{tau / 2, 1.5 * tau} {}
  Reaction at(double d) const override { return {k_ * (d - slack_[0] - slack_[1]), k_}; }
  void accept(double d, double seconds) override {
    const double force = at(d).force;
    for (std::size_t i = 0; i < slack_.size(); ++i)
      slack_[i] += (1 - std::exp(-seconds / tau_[i])) * (c_ * force - slack_[i]);
  }

 private:
  double k_, c_;
  std::array<double, 2> tau_, slack_{0, 0};
};

class Friction : public JointLaw {
 public:
  Friction(JointLawPointer beside, double force, double s)
      : beside_(std::move(beside)), force_(force), s_(s) {}
  Reaction at(double d) const override {
    const double z = advanced(d);
    const Reaction other = beside_->at(d);
    return {other.force + force_ * z, other.tangent + force_ * slope(z, d - d_)};
  }
  void accept(double d, double seconds) override {
    beside_->accept(d, seconds);
    z_ = advanced(d);
    d_ = d;
  }

 private:
  double slope(double z, double way) const {
    return (1 - std::pow(std::abs(z), 1.5) * (z * way >= 0 ? 1. : -0.2)) / s_;
  }
  // Runge-Kutta over the way from the last accepted point, a tenth of s at a time at most.
  double advanced(double d) const {
    const double way = d - d_;
    const int steps = std::clamp(static_cast<int>(std::ceil(std::abs(way) / (0.1 * s_))), 1, 400);
    const double h = way / steps;
    double z = z_;
    for (int i = 0; i < steps; ++i) {
      const double a = slope(z, h), b = slope(z + h / 2 * a, h), c = slope(z + h / 2 * b, h);
      z = std::clamp(z + h / 6 * (a + 2 * b + 2 * c + slope(z + h * c, h)), -1., 1.);
    }
    return z;
  }

  JointLawPointer beside_;
  double force_, s_, z_ = 0, d_ = 0;
};

class Dahl : public JointLaw {
 public:
  Dahl(JointLawPointer beside, double force, double s)
      : beside_(std::move(beside)), force_(force), s_(s) {}
  Reaction at(double d) const override {
    const Reaction other = beside_->at(d);
    const double way = d - d_, sign = way >= 0 ? 1 : -1;
    const double left = (1 - z_ * sign) * std::exp(-std::abs(way) / s_);
    return {other.force + force_ * sign * (1 - left), other.tangent + force_ / s_ * left};
  }
  void accept(double d, double seconds) override {
    beside_->accept(d, seconds);
    const double way = d - d_, sign = way >= 0 ? 1 : -1;
    z_ = sign * (1 - (1 - z_ * sign) * std::exp(-std::abs(way) / s_));
    d_ = d;
  }

 private:
  JointLawPointer beside_;
  double force_, s_, z_ = 0, d_ = 0;
};

class GearLoss : public JointLaw {
 public:
  GearLoss(JointLawPointer beside, double share, double s)
      : beside_(std::move(beside)), share_(share), s_(s) {}
  Reaction at(double d) const override {
    const Reaction other = beside_->at(d);
    const double way = d - d_, sign = way >= 0 ? 1 : -1;
    const double left = (1 - z_ * sign) * std::exp(-std::abs(way) / s_);
    const double z = sign * (1 - left), least = 1e-3 * s_ * other.tangent;
    const double limit = share_ * std::hypot(other.force, least);
    const double growth = share_ * share_ * other.force / limit * other.tangent;
    return {other.force + limit * z, other.tangent + growth * z + limit / s_ * left};
  }
  void accept(double d, double seconds) override {
    beside_->accept(d, seconds);
    const double way = d - d_, sign = way >= 0 ? 1 : -1;
    z_ = sign * (1 - (1 - z_ * sign) * std::exp(-std::abs(way) / s_));
    d_ = d;
  }

 private:
  JointLawPointer beside_;
  double share_, s_, z_ = 0, d_ = 0;
};

class Arctangent : public JointLaw {
 public:
  Arctangent(double k, double ratio, double d0) : k_(k), more_(k * (ratio - 1)), d0_(d0) {}
  Reaction at(double d) const override {
    const double u = d / d0_;
    return {k_ * d + more_ * (d - d0_ * std::atan(u)), k_ + more_ * u * u / (1 + u * u)};
  }

 private:
  double k_, more_, d0_;
};

class ServoDroop : public JointLaw {
 public:
  ServoDroop(double k, double droop, double d0)
      : k_(k), b_(droop * std::sqrt(d0)), r2_(d0 * d0 / 400) {}
  Reaction at(double d) const override {
    double e = d, slope = 1;
    for (int i = 0; i < 50; ++i) {
      const double q = std::pow(e * e + r2_, 0.25);
      slope = 1 + b_ * (1 / q - 0.5 * e * e / std::pow(q, 5));
      const double step = (e + b_ * e / q - d) / slope;
      e -= step;
      if (std::abs(step) < 1e-16) break;
    }
    return {k_ * e, k_ / slope};
  }

 private:
  double k_, b_, r2_;
};

}  // namespace

JointLawPointer linear_law(double k) { return std::make_shared<Linear>(k); }
JointLawPointer hardening_law(double k, double d0) { return std::make_shared<Hardening>(k, d0); }
JointLawPointer clearance_law(double k, double gap) { return std::make_shared<Clearance>(k, gap); }
JointLawPointer two_slope_law(double k, double ratio, double d1) {
  return std::make_shared<TwoSlopes>(k, ratio, d1);
}
JointLawPointer lifting_law(double k, double looser, double d1) {
  return std::make_shared<Lifting>(k, looser, d1);
}
JointLawPointer creep_law(double k, double c, double tau) {
  return std::make_shared<Creep>(k, c, tau);
}
JointLawPointer friction_law(JointLawPointer beside, double force, double s) {
  return std::make_shared<Friction>(std::move(beside), force, s);
}
JointLawPointer dahl_law(JointLawPointer beside, double force, double s) {
  return std::make_shared<Dahl>(std::move(beside), force, s);
}
JointLawPointer gear_loss_law(JointLawPointer beside, double share, double s) {
  return std::make_shared<GearLoss>(std::move(beside), share, s);
}
JointLawPointer arctangent_law(double k, double ratio, double d0) {
  return std::make_shared<Arctangent>(k, ratio, d0);
}
JointLawPointer servo_droop_law(double k, double droop, double d0) {
  return std::make_shared<ServoDroop>(k, droop, d0);
}

}  // namespace twin
