#include "kinetostat/fea/section/beam_study.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

namespace kinetostat::fea {
namespace {

constexpr double significant_share = 0.05;
constexpr const char* displacements[] = {"x", "y", "z", "rx", "ry", "rz"};
constexpr const char* loads[] = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};

std::string beams(std::size_t count) {
  return count == 1 ? "1 beam" : fmt::format("{} beams", count);
}

// Cuts and analyses one section after the other.
class Surveyor {
 public:
  Surveyor(const SectionCutter& cutter, const Curve& axis, double poisson,
           std::vector<std::string>& warnings)
      : cutter_(cutter), axis_(axis), poisson_(poisson), warnings_(warnings) {}

  /// Empty when there is no section here, or none that can be analysed, with a warning.
  std::optional<BeamStation> at(double arc) {
    const auto section = cutter_.section_at(axis_.point(arc), axis_.tangent(arc));
    if (!section) {
      warn(arc, "the plane across the axis meets no material");
      return std::nullopt;
    }
    try {
      return BeamStation{.arc = arc,
                         .frame = section->frame,
                         .centroid = section->centroid,
                         .properties = analyse(section->pieces, poisson_)};
    } catch (const SectionError& error) {
      warn(arc, error.what());
      return std::nullopt;
    }
  }

 private:
  void warn(double arc, const std::string& what) {
    warnings_.push_back(fmt::format("section at {:.3g} of the axis taken as rigid: {}",
                                    arc / axis_.length(), what));
  }

  const SectionCutter& cutter_;
  const Curve& axis_;
  double poisson_;
  std::vector<std::string>& warnings_;
};

BeamElement element(const BeamStation& station, double length) {
  return {.middle = station.frame, .length = length, .section = station.properties};
}

// Straight from one interface to the other, with the section in the middle of the axis turned to
// lie across.
BeamElement straight_beam(const BeamStation& half_way, const LinkBody& body) {
  const Vector3 start = body.fixed.centroid, end = body.loaded.centroid;
  BeamElement beam = element(half_way, (end - start).norm());
  beam.middle = section_frame((start + end) / 2, end - start, half_way.frame.axes.col(1));
  const Vector2 shift = beam.section.centroid;
  beam.section.centroid -= shift;
  beam.section.shear_centre -= shift;
  return beam;
}

BeamModel model(std::vector<BeamElement> elements, const Material& material, const Vector3& point) {
  const spatial::Compliance6 compliance = chain_compliance(elements, material, point);
  return {beams(elements.size()), std::move(elements), compliance};
}

std::vector<BeamElement> elements(const std::vector<BeamStation>& stations, double length) {
  std::vector<BeamElement> list;
  list.reserve(stations.size());
  for (const BeamStation& station : stations) list.push_back(element(station, length));
  return list;
}

void warn_of_pieces(BeamStudy& study) {
  const auto in_pieces =
      std::count_if(study.stations.begin(), study.stations.end(),
                    [](const BeamStation& s) { return s.properties.pieces > 1; });
  if (in_pieces > 0)
    study.warnings.push_back(fmt::format(
        "{} of {} sections are in several pieces: a beam takes them to bend as one and to twist "
        "and shear side by side",
        in_pieces, study.stations.size()));
}

std::string percent(double fraction) { return fmt::format("{:.2g} %", 100 * fraction); }

std::string with_worst(const BeamComparison& c) {
  return fmt::format("{} {} by up to {} ({} under {})", c.name,
                     c.name.starts_with("1 ") ? "differs" : "differ", percent(c.worst),
                     displacements[c.worst_row], loads[c.worst_column]);
}

}  // namespace

BeamStudy study_beams(const LinkBody& body, const Material& material, const Vector3& point,
                      const BeamOptions& options, common::Progress& progress) {
  constexpr const char* phase = "sections";
  progress.report(phase, 0);
  const SectionCutter cutter(body);
  BeamStudy study{.axis = cutter.find_axis(2 * options.stations + 1),
                  .stations = {},
                  .models = {},
                  .warnings = {}};
  Surveyor surveyor(cutter, study.axis, material.poisson(), study.warnings);
  // In the order of cost; what is found on the way is said once.
  const auto survey = [&](int count) {
    std::vector<BeamStation> stations;
    for (int k = 0; k < count; ++k) {
      progress.report(phase, static_cast<double>(k) / count);
      if (const auto station = surveyor.at((k + 0.5) / count * study.axis.length()))
        stations.push_back(*station);
    }
    if (stations.empty()) throw SectionError("no section of the link can be analysed");
    return stations;
  };
  study.stations = survey(options.stations);
  const BeamStation half_way = survey(1).front();
  const double length = study.axis.length();
  const auto add = [&](std::vector<BeamElement> beams) {
    study.models.push_back(model(std::move(beams), material, point));
  };
  add({straight_beam(half_way, body)});
  add(elements(survey(options.beams), length / options.beams));
  add(elements(study.stations, length / options.stations));
  warn_of_pieces(study);
  return study;
}

BeamComparison compare(const BeamModel& model, const spatial::Compliance6& fea) {
  const Matrix6 b = model.compliance.in(fea.frame()).matrix();
  const Matrix6& f = fea.matrix();
  BeamComparison c{.name = model.name,
                   .errors = Matrix6::Zero(),
                   .significant = Eigen::Matrix<bool, 6, 6>::Constant(false),
                   .worst = 0,
                   .worst_row = 0,
                   .worst_column = 0,
                   .least_ratio = 0,
                   .largest_ratio = 0};
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      const double size = std::sqrt(f(i, i) * f(j, j));
      c.significant(i, j) = std::abs(f(i, j)) >= significant_share * size;
      c.errors(i, j) = c.significant(i, j) ? b(i, j) / f(i, j) - 1 : (b(i, j) - f(i, j)) / size;
      if (!c.significant(i, j) || std::abs(c.errors(i, j)) <= c.worst) continue;
      c.worst = std::abs(c.errors(i, j));
      c.worst_row = i;
      c.worst_column = j;
    }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6> ratios(b, f, Eigen::EigenvaluesOnly);
  c.least_ratio = ratios.eigenvalues()[0];
  c.largest_ratio = ratios.eigenvalues()[5];
  return c;
}

std::string verdict(const std::vector<BeamComparison>& comparisons, double tolerance) {
  std::string so_far;
  for (const BeamComparison& c : comparisons) {
    if (c.worst <= tolerance)
      return fmt::format("{} {} enough for {}: {} within {} of FEA in every significant entry{}.",
                         c.name, c.name.starts_with("1 ") ? "is" : "are", percent(tolerance),
                         c.name.starts_with("1 ") ? "it is" : "they are", percent(c.worst),
                         so_far.empty() ? "" : "; " + so_far);
    so_far += (so_far.empty() ? "" : ", ") + with_worst(c);
  }
  return fmt::format("No beam model is within {} of FEA: {}; use the FEA result.",
                     percent(tolerance), so_far);
}

}  // namespace kinetostat::fea
