#include "kinetostat/calibration/search/free_form.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/regression/evidence.h"
#include "kinetostat/calibration/sensors/weight.h"
#include "kinetostat/calibration/statistics/residual_space.h"
#include "kinetostat/spatial/decomposition.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index most_rank = 60;         // of a kernel: what is rougher counts as noise
constexpr double rest_of_trace = 1e-3;  // where its factorisation ends

// One row a reading; columns that do not vary are left out, the others have unit variance.
MatrixXd standardised(const MatrixXd& features) {
  MatrixXd result(features.rows(), features.cols());
  Index kept = 0;
  for (Index j = 0; j < features.cols(); ++j) {
    const double mean = features.col(j).mean();
    const double deviation = std::sqrt((features.col(j).array() - mean).square().mean());
    if (!(deviation > 1e-9 * (std::abs(mean) + 1e-300))) continue;
    result.col(kept++) = (features.col(j).array() - mean) / deviation;
  }
  return result.leftCols(kept);
}

MatrixXd postures_of(const Campaign& campaign) {
  std::map<std::string, Index> joints;
  for (const Configuration& c : campaign.configurations)
    for (const auto& [name, value] : c.joints) joints.emplace(name, 0);
  Index next = 6;
  for (auto& [name, column] : joints) column = next++;
  MatrixXd features = MatrixXd::Zero(static_cast<Index>(campaign.readings.size()), next);
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    const Configuration& c = campaign.configurations[campaign.readings[i].configuration];
    const auto row = static_cast<Index>(i);
    if (c.target)
      features.row(row).head<6>() << c.target->position().transpose(),
          spatial::log_rotation(c.target->rotation()).transpose();
    for (const auto& [name, value] : c.joints) features(row, joints.at(name)) = value;
  }
  return standardised(features);
}

// About one point, however they are written. Not about their mean: the sign of a load matters.
MatrixXd loads_of(const Campaign& campaign) {
  MatrixXd features(static_cast<Index>(campaign.readings.size()), 6);
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    features.row(static_cast<Index>(i)) =
        campaign.readings[i].load.at_reference_point(spatial::Pose()).transpose();
    features.row(static_cast<Index>(i)) += load_in_joints(campaign.readings[i].load).transpose();
    features.row(static_cast<Index>(i)).head<3>() +=
        force_at_nodes(campaign.readings[i].load).transpose();
  }
  Index kept = 0;
  for (Index j = 0; j < 6; ++j) {
    const double size = features.col(j).cwiseAbs().maxCoeff();
    if (size > 0) features.col(kept++) = features.col(j) * (1.5 / size);
  }
  return features.leftCols(kept);
}

template <typename Number>
MatrixXd numbers_of(const Campaign& campaign, const Number& number) {
  MatrixXd features = MatrixXd::Zero(static_cast<Index>(campaign.readings.size()), 1);
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    features(static_cast<Index>(i), 0) = number(i);
  return standardised(features);
}

MatrixXd times_in_cycle(const Campaign& campaign) {
  VectorXd seconds = VectorXd::Zero(static_cast<Index>(campaign.readings.size()));
  for (const Cycle& cycle : load_cycles(campaign))
    for (const std::size_t i : cycle)
      seconds[static_cast<Index>(i)] =
          campaign.readings[i].time.value_or(0) - campaign.readings[cycle.front()].time.value_or(0);
  return numbers_of(campaign, [&](std::size_t i) { return seconds[static_cast<Index>(i)]; });
}

double mean_of(const Covariate& covariate) {
  double sum = 0, known = 0;
  for (std::size_t i = 0; i < covariate.values.size(); ++i)
    if (const std::optional<double> number = covariate.number(i)) {
      sum += *number;
      ++known;
    }
  return known == 0 ? 0 : sum / known;
}

// One column for each of a few words, which of them each reading has.
MatrixXd words_of(const Covariate& covariate) {
  constexpr std::size_t most_words = 8;
  const std::set<std::string> words(covariate.values.begin(), covariate.values.end());
  if (words.size() > most_words) return {};
  MatrixXd which(covariate.values.size(), words.size());
  Index column = 0;
  for (const std::string& word : words) {
    for (std::size_t i = 0; i < covariate.values.size(); ++i)
      which(static_cast<Index>(i), column) = covariate.values[i] == word ? 1 : 0;
    ++column;
  }
  return standardised(which);
}

// Of a column that the format does not know. Empty cells are like the mean.
MatrixXd column_of(const Campaign& campaign, const Covariate& covariate) {
  if (!covariate.is_numeric()) return words_of(covariate);
  const double mean = mean_of(covariate);
  return numbers_of(campaign, [&](std::size_t i) { return covariate.number(i).value_or(mean); });
}

MatrixXd with_sizes(const MatrixXd& numbers) {
  return beside(beside(numbers, numbers.cwiseAbs()), numbers.rowwise().norm());
}

// What has names of its own, and what was read, from which some columns are computed.
MatrixXd known_of(const Campaign& campaign, const MatrixXd& conditions, const MatrixXd& loads) {
  MatrixXd read = MatrixXd::Zero(static_cast<Index>(campaign.readings.size()), campaign.size());
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    for (const Index component : components_in_use(campaign.readings[i]))
      read(static_cast<Index>(i), component) = campaign.readings[i].displacement[component];
  return span_of(standardised(beside(conditions, beside(with_sizes(loads), with_sizes(read)))),
                 1e-6);
}

// Whether a column says little that is new (Ezekiel's adjusted R^2).
bool follows(const MatrixXd& column, const MatrixXd& known) {
  constexpr double closely = 0.8;
  const auto n = static_cast<double>(column.rows()), k = static_cast<double>(known.cols());
  if (n < k + 2) return true;
  const double rest = 1 - (known.transpose() * column).squaredNorm() / column.squaredNorm();
  return 1 - rest * (n - 1) / (n - k - 1) > closely;
}

std::vector<std::pair<std::string, MatrixXd>> new_columns(const Campaign& campaign,
                                                          const MatrixXd& known) {
  std::vector<std::pair<std::string, MatrixXd>> result;
  for (const Covariate& covariate : campaign.covariates)
    if (MatrixXd column = column_of(campaign, covariate); !follows(column, known))
      result.emplace_back(covariate.name, std::move(column));
  return result;
}

MatrixXd branches_of(const Campaign& campaign) {
  const std::vector<LoadDirection> directions = branches(campaign);
  return numbers_of(campaign, [&](std::size_t i) {
    return directions[i] == LoadDirection::loading     ? 1.0
           : directions[i] == LoadDirection::unloading ? -1.0
                                                       : 0.0;
  });
}

// Columns that distinguish the measured components.
MatrixXd components_of(const Campaign& campaign, const std::vector<Value>& values) {
  MatrixXd result = MatrixXd::Zero(static_cast<Index>(values.size()), campaign.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    result(static_cast<Index>(i), values[i].component) = 1;
  return result;
}

MatrixXd of_unit_length(MatrixXd columns) {
  for (Index j = 0; j < columns.cols(); ++j)
    if (const double length = columns.col(j).norm(); length > 0) columns.col(j) /= length;
  return columns;
}

// Values of one component along a cycle: the row of each, and its time [s].
using Track = std::vector<std::pair<Index, double>>;

std::vector<Track> tracks_of(const Campaign& campaign, const std::vector<Value>& values) {
  std::map<std::pair<std::size_t, Index>, Index> rows;
  for (std::size_t v = 0; v < values.size(); ++v)
    rows[{values[v].reading, values[v].component}] = static_cast<Index>(v);
  std::vector<Track> tracks;
  for (const Cycle& cycle : load_cycles(campaign))
    for (Index component = 0; component < campaign.size(); ++component) {
      Track& track = tracks.emplace_back();
      for (const std::size_t reading : cycle)
        if (const auto row = rows.find({reading, component});
            row != rows.end() && campaign.readings[reading].time)
          track.emplace_back(row->second, *campaign.readings[reading].time);
    }
  return tracks;
}

// What is left of each step of the load since the cycle started, as far as what is uncertain feels
// it: of every column the sum of its steps, each over e times less after the time of fading.
MatrixXd memory(const std::vector<Track>& tracks, DisplacementKind displacement,
                const MatrixXd& uncertain, double fading) {
  MatrixXd result = MatrixXd::Zero(uncertain.rows(), uncertain.cols());
  for (const Track& track : tracks)
    for (std::size_t k = 0; k < track.size(); ++k) {
      const auto [row, now] = track[k];
      if (k == 0) {
        if (displacement == DisplacementKind::difference) result.row(row) = uncertain.row(row);
        continue;
      }
      const auto [before, then] = track[k - 1];
      result.row(row) = std::exp(-(now - then) / fading) *
                        (result.row(before) + uncertain.row(row) - uncertain.row(before));
    }
  return result;
}

}  // namespace

// Of the covariance root root'.
FreeForm::Spectrum FreeForm::spectrum(const MatrixXd& root, const ResidualSpace& space) {
  if (root.cols() == 0) return {};
  const MatrixXd left = space.left_of(root);
  MatrixXd gram = MatrixXd::Zero(left.cols(), left.cols());
  gram.selfadjointView<Eigen::Lower>().rankUpdate(left.transpose());
  spatial::SymmetricEigen eigen = spatial::symmetric_eigen(gram);
  return {std::move(eigen.values),
          eigen.vectors.transpose() * (left.transpose() * space.residual())};
}

// Of one process, averaged over its amplitude: from a signature of about three standard deviations
// in all the readings to one of two hundred.
double FreeForm::log_evidence(const Spectrum& spectrum, double exponent) {
  const auto& [values, seen] = spectrum;
  if (values.size() == 0) return 0;  // a memory that has faded before the next reading
  const double largest = values.maxCoeff(), trace = values.sum();
  if (!(largest > 0)) return 0;
  std::vector<double> logs;
  for (int half_powers = 2; half_powers <= 9; ++half_powers) {
    double log = 0;
    for (Index i = 0; i < seen.size(); ++i) {
      const double value = values[i];
      if (value < 1e-9 * largest) continue;
      const double signal = std::pow(10, 0.5 * half_powers) * value / trace;
      log +=
          0.5 * (exponent * seen[i] * seen[i] / value * signal / (1 + signal) - std::log1p(signal));
    }
    logs.push_back(log);
  }
  return log_mean_exp(logs);
}

double FreeFormEvidence::p_value() const { return std::min(1.0, std::exp(-log)); }

namespace {

// Whether several postures were read one after the other, none twice: what depends on them then
// depends on the time as well.
bool is_read_in_turn(const Campaign& campaign) {
  std::vector<std::pair<double, std::size_t>> visits;  // time and configuration
  for (const Reading& reading : campaign.readings)
    if (is_used(reading)) visits.emplace_back(reading.time.value_or(0), reading.configuration);
  std::sort(visits.begin(), visits.end());
  std::set<std::size_t> seen;
  for (std::size_t i = 0; i < visits.size(); ++i) {
    const bool is_new = i == 0 || visits[i].second != visits[i - 1].second;
    if (is_new && !seen.insert(visits[i].second).second) return false;
  }
  return seen.size() > 1;
}

}  // namespace

std::vector<FreeFormEvidence::Part> FreeFormEvidence::parts() const {
  return shared.empty() ? std::vector<Part>{{over, drive}} : shared;
}

FreeForm::FreeForm(const Campaign& campaign, const std::vector<Value>& values,
                   const FreeFormWays& ways) {
  for (const Value& value : values) reading_.push_back(static_cast<Index>(value.reading));
  const MatrixXd postures = postures_of(campaign), loads = loads_of(campaign);
  const MatrixXd branches = branches_of(campaign), held = times_in_cycle(campaign);
  const auto time = [&](std::size_t i) { return campaign.readings[i].time.value_or(0); };
  const auto heat = [&](std::size_t i) { return campaign.readings[i].temperature.value_or(0); };
  const MatrixXd times = numbers_of(campaign, time), heats = numbers_of(campaign, heat);
  const auto further = new_columns(campaign, known_of(campaign, beside(times, heats), loads));
  const auto uncertain = std::make_shared<const MatrixXd>(of_unit_length(ways.uncertain));
  const std::string time_in_words =
      is_read_in_turn(campaign) ? "time or posture, which change together here" : "time";
  const auto add_through = [&](const std::shared_ptr<const MatrixXd>& columns,
                               const std::string& how) {
    add("posture" + how, SmoothOver::other, postures, columns, {0, 2.5, 1});
    add("load" + how, SmoothOver::other, loads, columns, {0, 2.5, 1});
    if (postures.cols() > 0 && loads.cols() > 0)
      add("posture and load together" + how, SmoothOver::other, beside(postures, loads), columns,
          {0, 2.5, 1});
    if (branches.cols() > 0)
      add("load, and whether it rises or falls" + how, SmoothOver::other, beside(loads, branches),
          columns, {0, 1});
    add(time_in_words + how, SmoothOver::time, times, columns, {0, 1, 0.3});
    add("time in the cycle" + how, SmoothOver::time, held, columns, {0, 1});
    if (loads.cols() > 0 && held.cols() > 0)
      add("load and time in the cycle together" + how, SmoothOver::other, beside(loads, held),
          columns, {0, 1});
    add("temperature" + how, SmoothOver::temperature, heats, columns, {0, 2.5, 1});
    for (const auto& [name, column] : further)
      add(fmt::format("the column '{}'{}", name, how), SmoothOver::column, column, columns, {0, 1});
  };
  add_through(std::make_shared<const MatrixXd>(components_of(campaign, values)), "");
  add_through(std::make_shared<const MatrixXd>(of_unit_length(ways.force)),
              ", as a force on the platform does");
  add_through(uncertain, ", as a change of what is uncertain does");
  add_memory(campaign, values, *uncertain);
  for (const FreeFormWays::Drive& drive : ways.drives) add_law(drive);
  share_prior();
}

void FreeForm::add(const std::string& depends_on, SmoothOver over, MatrixXd of_reading,
                   const std::shared_ptr<const MatrixXd>& columns,
                   std::initializer_list<double> lengths) {
  if (of_reading.cols() == 0 || columns->size() == 0 || columns->isZero(0)) return;
  const auto shared = std::make_shared<const MatrixXd>(std::move(of_reading));
  for (const double length : lengths)
    processes_.push_back({depends_on, over, shared, columns, length});
}

void FreeForm::add_memory(const Campaign& campaign, const std::vector<Value>& values,
                          const MatrixXd& uncertain) {
  const auto of_nothing = std::make_shared<const MatrixXd>(campaign.readings.size(), 0);
  const std::vector<Track> tracks = tracks_of(campaign, values);
  for (const double fading : {20.0, 60.0, 200.0, 600.0, 2000.0}) {  // [s]
    MatrixXd columns = memory(tracks, campaign.displacement, uncertain, fading);
    if (!columns.isZero(0))
      processes_.push_back({"earlier loads, as a change of what is uncertain does",
                            SmoothOver::earlier_loads, of_nothing,
                            std::make_shared<const MatrixXd>(std::move(columns)), 0});
  }
}

void FreeForm::add_law(const FreeFormWays::Drive& drive) {
  const double largest = drive.deflection.cwiseAbs().maxCoeff();
  if (!(largest > 0) || drive.by_stiffness.isZero(0)) return;
  const auto load = std::make_shared<const MatrixXd>(drive.deflection * (1.5 / largest));
  const auto columns = std::make_shared<const MatrixXd>(of_unit_length(drive.by_stiffness));
  for (const double length : {1.0, 0.4})
    processes_.push_back({"the load of " + drive.name + ", as a law of that drive does",
                          SmoothOver::other, load, columns, length, drive.name});
}

// Few of the columns that a table has beside the known ones mean anything.
void FreeForm::share_prior() {
  constexpr double share_of_columns = 0.02;
  const auto is_column = [](const Process& process) { return process.over == SmoothOver::column; };
  const auto columns =
      static_cast<double>(std::count_if(processes_.begin(), processes_.end(), is_column));
  const double known = static_cast<double>(processes_.size()) - columns;
  const double share = columns == 0 ? 0 : share_of_columns;
  for (Process& process : processes_)
    process.log_prior = std::log(is_column(process) ? share / columns : (1 - share) / known);
}

// Kernel = root root', by a Cholesky factorisation with pivots that ends when little is left
// (Harbrecht, Peters and Schneider, Appl. Numer. Math. 62, 2012).
MatrixXd FreeForm::root_of_kernel(const Process& process) const {
  const MatrixXd f = (*process.of_reading)(reading_, Eigen::all);
  const MatrixXd& columns = *process.columns;
  const double length = process.length;
  const auto along = [&](Index pivot) -> VectorXd {
    if (length == 0) return (1 + (f * f.row(pivot).transpose()).array()).matrix();
    return (-(f.rowwise() - f.row(pivot)).rowwise().squaredNorm() / (2 * length * length))
        .array()
        .exp()
        .matrix();
  };
  VectorXd left = columns.rowwise().squaredNorm();
  if (length == 0) left.array() *= 1 + f.rowwise().squaredNorm().array();
  const double enough = rest_of_trace * left.sum();
  MatrixXd root(f.rows(), std::min(most_rank, f.rows()));
  Index rank = 0;
  for (; rank < root.cols() && left.sum() > enough; ++rank) {
    Index pivot = 0;
    const double largest = left.maxCoeff(&pivot);
    root.col(rank) = along(pivot).cwiseProduct(columns * columns.row(pivot).transpose()) -
                     root.leftCols(rank) * root.row(pivot).head(rank).transpose();
    root.col(rank) /= std::sqrt(largest);
    left = (left - root.col(rank).cwiseAbs2()).cwiseMax(0);
  }
  return root.leftCols(rank);
}

const std::vector<FreeForm::Spectrum>& FreeForm::spectra_in(const ResidualSpace& space) const {
  constexpr std::size_t most_known = 4;
  for (const Known& known : known_)
    if (known.space.dimension() == space.dimension() &&
        known.space.residual() == space.residual() && known.space.basis() == space.basis())
      return known.spectra;
  if (known_.size() == most_known) known_.pop_front();
  known_.push_back({space, {}});
  Known& known = known_.back();
  for (const Process& process : processes_)
    known.spectra.push_back(spectrum(root_of_kernel(process), space));
  return known.spectra;
}

FreeFormEvidence FreeForm::evidence(const ResidualSpace& space, double exponent) const {
  const std::lock_guard lock(known_in_use_);
  const std::vector<Spectrum>& spectra = spectra_in(space);
  FreeFormEvidence result;
  std::vector<double> logs;
  double most = 0;
  for (std::size_t p = 0; p < processes_.size(); ++p) {
    const Process& process = processes_[p];
    logs.push_back(log_evidence(spectra[p], exponent) + process.log_prior);
    if (result.depends_on.empty() || logs.back() > most) {
      most = logs.back();
      result.depends_on = process.depends_on;
      result.drive = process.drive;
      result.over = process.over;
    }
  }
  if (logs.empty()) return result;
  result.log = log_mean_exp(logs) + std::log(static_cast<double>(logs.size()));
  std::map<std::pair<SmoothOver, std::string>, double> shares;
  for (std::size_t i = 0; i < logs.size(); ++i)
    shares[{processes_[i].over, processes_[i].drive}] += std::exp(logs[i] - result.log);
  for (const auto& [of, share] : shares) result.shared.push_back({of.first, of.second, share});
  return result;
}

}  // namespace kinetostat::calibration
