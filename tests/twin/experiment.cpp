#include "experiment.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <stdexcept>

#include <Eigen/QR>
#include <fmt/format.h>

#include "day.h"
#include "instrument.h"

namespace twin {
namespace {

Posture random_posture(const RobotSpec& robot, Random& random) {
  if (!robot.serial) {
    Vector3 point = robot.centre;
    for (int i = 0; i < 3; ++i)
      if (robot.reach[i] > 0) point[i] += random.uniform(-robot.reach[i], robot.reach[i]);
    return posture_at(robot, point);
  }
  std::vector<double> q;
  for (const Item& item : robot.chains[0].items)
    if (item.kind == Item::actuator) {
      if (item.axes[0] < 3) {
        q.push_back(std::round((item.home + random.uniform(-0.2, 0.2)) * 1e6) / 1e6);
        continue;
      }
      const double way = q.size() < 3 ? 35 * degree : 60 * degree;
      q.push_back(item.home + (robot.springs().size() == 2 ? 0.5 : 1) * random.uniform(-way, way));
      // As it is written into the file.
      q.back() = std::round(q.back() / degree * 1e3) / 1e3 * degree;
    }
  return posture_of(robot,
                    Eigen::Map<Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size())));
}

std::vector<Vector3> load_directions(const RobotSpec& robot, Random& random) {
  if (robot.springs().size() == 2) return {Vector3::UnitZ()};
  if (robot.planar) {
    const double angle = random.uniform(0, 2 * std::numbers::pi);
    return {Vector3::UnitX(), Vector3::UnitY(), {std::cos(angle), std::sin(angle), 0}};
  }
  return {Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ(), random.direction()};
}

Vector3 rounded(const Vector3& force) { return (force.array() * 1e3).round() / 1e3; }

Plan loads_plan(const RobotSpec& robot, Random& random, const std::vector<double>& levels) {
  const bool single = robot.springs().size() == 2;
  Plan plan;
  plan.rotations = single || !robot.serial;
  const int postures = single ? 3 : 4;
  for (int p = 0; p < postures; ++p) plan.postures.push_back(random_posture(robot, random));
  int cycle = 0;
  for (const char* session : {"monday", "tuesday"}) {
    Day day(random);
    double time = 0;
    for (int p = 0; p < postures; ++p) {
      // Half of the postures each day, on the bench all of them.
      if (!single && p % 2 != (session[0] == 't')) continue;
      for (const Vector3& direction : load_directions(robot, random)) {
        ++cycle;
        for (std::size_t i = 0; i < levels.size(); ++i) {
          time += random.uniform(20, 40);
          Row row{
              .posture = p, .session = session, .cycle = cycle, .step = static_cast<int>(i) + 1};
          row.time = std::round(time);
          row.force = rounded(levels[i] * robot.largest_force * direction);
          row.unloading = i > 0 && std::abs(levels[i]) < std::abs(levels[i - 1]);
          row.starts = i == 0;
          day.tell(row);
          plan.rows.push_back(row);
        }
        time += random.uniform(200, 400);
      }
    }
  }
  return plan;
}

}  // namespace

Plan cycle_plan(const RobotSpec& robot, Random& random) {
  return loads_plan(robot, random,
                    {0.33, 0.67, 1, 0.67, 0.33, 0, -0.33, -0.67, -1, -0.67, -0.33, 0});
}

Plan one_way_plan(const RobotSpec& robot, Random& random) {
  return loads_plan(robot, random, {0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1});
}

Plan push_plan(const RobotSpec& robot, Random& random) {
  return loads_plan(robot, random, {0.5, 1, 0.5, 0, -0.5, -1, 0});
}

Plan weight_plan(const RobotSpec& robot, Random& random) {
  Plan plan;
  plan.rotations = !robot.serial;
  int cycle = 0;
  Day day(random);
  double time = 0;
  for (int i = 0; i < 12; ++i) {
    plan.postures.push_back(random_posture(robot, random));
    ++cycle;
    for (const double level : {0.5, 1.0, 0.5, 0.0}) {
      time += random.uniform(40, 80);
      Row row{.posture = i, .session = "monday", .cycle = cycle};
      row.step = static_cast<int>(plan.rows.size() % 4) + 1;
      row.time = std::round(time);
      row.force = rounded(-level * robot.largest_force * Vector3::UnitZ());
      row.starts = row.step == 1;
      row.unloading = row.step > 2;
      day.tell(row);
      plan.rows.push_back(row);
    }
    time += random.uniform(200, 400);
  }
  return plan;
}

Plan pose_plan(const RobotSpec& robot, Random& random) {
  Plan plan;
  plan.absolute = true;
  plan.rotations = !robot.serial;
  int cycle = 0;
  for (const char* session : {"monday", "tuesday"}) {
    Day day(random);
    double time = 0;
    for (int i = 0; i < 24; ++i) {
      plan.postures.push_back(random_posture(robot, random));
      Vector3 direction = random.direction();
      if (robot.planar) direction = Vector3(direction.x(), direction.y(), 0).normalized();
      ++cycle;
      for (int k = 0; k < 3; ++k) {
        time += k == 0 ? random.uniform(600, 1200) : random.uniform(20, 40);
        Row row{.posture = static_cast<int>(plan.postures.size()) - 1,
                .session = session,
                .cycle = cycle,
                .step = k + 1};
        row.time = std::round(time);
        row.starts = k == 0;
        if (k > 0) row.force = rounded((k == 1 ? 1 : -1) * robot.largest_force * direction);
        row.unloading = k == 2;
        day.tell(row);
        plan.rows.push_back(row);
      }
    }
  }
  return plan;
}

Plan plan_named(const std::string& name, const RobotSpec& robot, Random& random) {
  if (name == "cycles") return cycle_plan(robot, random);
  if (name == "one_way") return one_way_plan(robot, random);
  if (name == "poses") return pose_plan(robot, random);
  if (name == "push") return push_plan(robot, random);
  if (name == "weights") return weight_plan(robot, random);
  throw std::invalid_argument("no plan " + name);
}

namespace {

bool creeps(const std::vector<HiddenEffect>& effects) {
  return std::any_of(effects.begin(), effects.end(),
                     [](const HiddenEffect& e) { return e.name == "creep"; });
}

bool has_memory(const std::vector<HiddenEffect>& effects) {
  return std::any_of(effects.begin(), effects.end(), remembers_loads);
}

// One cycle after the other, each on a robot that stood relaxed.
class Run {
 public:
  Run(const World& world, const Plan& plan, bool with_derivatives, Responses& out)
      : world_(world), plan_(plan), with_derivatives_(with_derivatives), out_(out) {}

  void read(std::size_t i) {
    const Row& row = plan_.rows[i];
    if (row.starts) start(row);
    reach(row);
    const Pose now = built_.structure.pose_of(built_.platform);
    const Pose shown = instrument_.shown(seen(world_.effects, now, row), row);
    const Pose loaded_from = plan_.absolute ? unloaded_ : zero_;
    const auto column = static_cast<Eigen::Index>(i);
    out_.read.col(column) =
        difference(plan_.absolute ? Pose{} : seen(world_.effects, zero_, zero_row_), shown);
    out_.elastic.col(column) = difference(loaded_from, now);
    out_.positions[i] = now.x;
    if (!with_derivatives_) return;
    out_.by_springs[i] = built_.structure.sensitivity(built_.platform, springs());
    if (!plan_.absolute) out_.by_springs[i] -= zero_by_springs_;
  }

 private:
  int springs() const { return static_cast<int>(world_.robot.springs().size()); }

  // Rotation vectors are those of the turn from the first to the second, base axes.
  static Vector6 difference(const Pose& from, const Pose& to) {
    Vector6 d;
    d << to.x - from.x, vector_of(to.R * from.R.transpose());
    return d;
  }

  void start(const Row& row) {
    const Posture& posture = plan_.postures[static_cast<std::size_t>(row.posture)];
    built_ = build(world_.robot, posture, {world_.factors, world_.elements});
    for (const HiddenEffect& effect : world_.effects)
      apply_to_structure(effect, world_.robot, posture, built_);
    rests_.clear();
    for (const Coupling& coupling : built_.structure.couplings()) rests_.push_back(coupling.rest);
    apply_conditions(world_.effects, rests_, row, built_);
    if (!built_.structure.settle({})) throw std::runtime_error("the twin finds no equilibrium");
    built_.structure.accept(0);
    zero_ = unloaded_ = built_.structure.pose_of(built_.platform);
    zero_row_ = row;
    instrument_ = Instrument(world_.effects, seen(world_.effects, zero_, row));
    if (with_derivatives_ && !plan_.absolute)
      zero_by_springs_ = built_.structure.sensitivity(built_.platform, springs());
    force_ = applied_ = Vector3::Zero();
    time_ = row.time;
  }

  // The old load stays for nine tenths of the time, then it changes to the new one.
  void reach(const Row& row) {
    apply_conditions(world_.effects, rests_, row, built_);
    const bool remembers = has_memory(world_.effects);
    const int holds = creeps(world_.effects) ? 4 : 1, ramps = remembers ? 8 : 1;
    const double seconds = row.time - time_;
    if (remembers)
      for (int i = 0; i < holds; ++i) go(force_, 0.9 * seconds / holds, row);
    for (int i = 1; i <= ramps; ++i)
      go(force_ + (row.force - force_) * i / ramps, 0.1 * seconds / ramps, row);
    force_ = row.force;
    time_ = row.time;
  }

  void go(const Vector3& force, double seconds, const Row& row) {
    const Structure before = built_.structure;
    for (int parts = 1; parts <= 64; parts *= 4) {
      built_.structure = before;
      bool settled = true;
      for (int i = 1; i <= parts && settled; ++i)
        settled = built_.structure.settle({load(applied_ + (force - applied_) * i / parts, row)});
      if (!settled) continue;
      built_.structure.accept(seconds);
      applied_ = force;
      return;
    }
    throw std::runtime_error("the twin finds no equilibrium");
  }

  DeadLoad load(const Vector3& force, Row row) const {
    row.force = force;
    return actual_load(world_.effects, row, built_.platform);
  }

  const World& world_;
  const Plan& plan_;
  bool with_derivatives_;
  Responses& out_;
  Built built_;
  std::vector<Vector6> rests_;
  Pose zero_, unloaded_;
  Instrument instrument_;
  Row zero_row_;
  double time_ = 0;
  Vector3 force_ = Vector3::Zero(), applied_ = Vector3::Zero();
  Eigen::MatrixXd zero_by_springs_;
};

}  // namespace

Responses respond(const World& world, const Plan& plan, bool with_derivatives) {
  Responses out;
  const std::size_t n = plan.rows.size();
  out.read.resize(6, static_cast<Eigen::Index>(n));
  out.elastic.resize(6, static_cast<Eigen::Index>(n));
  out.positions.resize(n);
  if (with_derivatives) out.by_springs.resize(n);
  Run run(world, plan, with_derivatives, out);
  for (std::size_t i = 0; i < n; ++i) run.read(i);
  return out;
}

Eigen::Matrix<double, 6, Eigen::Dynamic> stated_noise(const RobotSpec& robot,
                                                      const Responses& base) {
  Vector6 instrument;
  if (robot.serial)
    instrument << 8e-6, 8e-6, 12e-6, Vector3::Constant(2e-5);
  else
    instrument << 1.0e-6, 1.0e-6, 1.5e-6, Vector3::Constant(1e-5);
  return ((wrench_noise * base.elastic.array()).square().colwise() + instrument.array().square())
      .sqrt();
}

Whitened::Whitened(const Plan& plan, const Responses& base,
                   const Eigen::Matrix<double, 6, Eigen::Dynamic>& noise)
    : components_(plan.rotations ? 6 : 3), base_(base), noise_(noise) {
  const Eigen::Index springs = base.by_springs.at(0).cols(), n = base.read.cols();
  std::map<std::string, Eigen::Index> sessions;
  for (const Row& row : plan.rows)
    sessions.emplace(row.session, static_cast<Eigen::Index>(sessions.size()));
  const Eigen::Index frames = plan.absolute ? 6 * static_cast<Eigen::Index>(sessions.size()) : 0;
  Eigen::MatrixXd columns(components_ * n, springs + frames);
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    Eigen::Matrix<double, 6, Eigen::Dynamic> values = Eigen::MatrixXd::Zero(6, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto row = static_cast<std::size_t>(i);
      if (k < springs) {
        values.col(i) = base.by_springs[row].col(k);
      } else if ((k - springs) / 6 == sessions.at(plan.rows[row].session)) {
        const Eigen::Index motion = (k - springs) % 6;
        values(motion, i) = 1;
        if (motion >= 3)
          values.col(i).head<3>() = Vector3::Unit(motion - 3).cross(base.positions[row]);
      }
    }
    columns.col(k) = whiten(values);
    if (const double length = columns.col(k).norm(); length > 0) columns.col(k) /= length;
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  qr.setThreshold(1e-9);
  basis_ = qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), qr.rank());
}

Eigen::VectorXd Whitened::whiten(const Eigen::Matrix<double, 6, Eigen::Dynamic>& values) const {
  const Eigen::MatrixXd scaled =
      values.topRows(components_).cwiseQuotient(noise_.topRows(components_));
  return Eigen::Map<const Eigen::VectorXd>(scaled.data(), scaled.size());
}

Eigen::VectorXd Whitened::mark_of(const Responses& other) const {
  const Eigen::VectorXd all = whiten(other.read - base_.read);
  return all - basis_ * (basis_.transpose() * all);
}

}  // namespace twin
