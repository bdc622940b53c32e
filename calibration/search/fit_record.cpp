#include "kinetostat/calibration/search/fit_record.h"

#include <cstring>
#include <stdexcept>
#include <type_traits>

#include "kinetostat/io/text_file.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;

class Writer {
 public:
  void raw(const void* data, std::size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }
  void require(std::size_t) const {}
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class Reader {
 public:
  explicit Reader(const std::string& bytes) : bytes_(bytes) {}

  void raw(void* data, std::size_t size) {
    require(size);
    if (size > 0) std::memcpy(data, bytes_.data() + at_, size);
    at_ += size;
  }
  /// So many bytes are still to come.
  void require(std::size_t size) const {
    if (size > bytes_.size() - at_) throw std::out_of_range("a record ends too early");
  }
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  const std::string& bytes_;
  std::size_t at_ = 0;
};

// Goes over the members of values, to write them or to fill them: each is listed once.
template <class Stream>
class Members {
 public:
  explicit Members(Stream& stream) : stream_(stream) {}

  template <class... T>
  void operator()(T&... values) {
    (one(values), ...);
  }

 private:
  template <class T>
  void one(T& value) requires(std::is_arithmetic_v<T> || std::is_enum_v<T>) {
    stream_.raw(&value, sizeof value);
  }
  void one(bool& value) {
    std::uint8_t byte = value ? 1 : 0;
    one(byte);
    if (byte > 1) throw std::out_of_range("a record says neither yes nor no");
    value = byte == 1;
  }
  template <class List>
  void sized(List& list) {
    std::size_t size = list.size();
    one(size);
    stream_.require(size);  // an entry takes at least a byte
    list.resize(size);
  }
  void one(std::string& text) {
    sized(text);
    stream_.raw(text.data(), text.size());
  }
  template <class T>
  void one(std::vector<T>& list) {
    sized(list);
    for (T& entry : list) one(entry);
  }
  template <class T>
  void one(std::optional<T>& value) {
    bool there = value.has_value();
    one(there);
    if (!there) return;
    if (!value) value = T{};
    one(*value);
  }
  template <class Matrix>
  static bool is_size_of(Index rows, Index cols) {
    constexpr Index most = Index{1} << 28;  // the product of both and of 8 is a number, too
    const auto fits = [](Index size, Index fixed) {
      return size >= 0 && size < most && (fixed == Eigen::Dynamic || size == fixed);
    };
    return fits(rows, Matrix::RowsAtCompileTime) && fits(cols, Matrix::ColsAtCompileTime);
  }
  template <class Matrix>
  void one(Eigen::PlainObjectBase<Matrix>& matrix) {
    Index rows = matrix.rows(), cols = matrix.cols();
    (*this)(rows, cols);
    if (!is_size_of<Matrix>(rows, cols)) throw std::out_of_range("a record of another matrix");
    const std::size_t size = sizeof(double) * static_cast<std::size_t>(rows * cols);
    stream_.require(size);
    matrix.resize(rows, cols);
    stream_.raw(matrix.data(), size);
  }
  void one(spatial::Pose& pose) {
    spatial::Matrix3 rotation = pose.rotation();
    spatial::Vector3 position = pose.position();
    (*this)(rotation, position);
    pose = spatial::Pose(rotation, position);
  }
  void one(vjm::SystemState& s) { (*this)(s.bodies, s.wrenches, s.coordinates); }
  void one(Zero& z) { (*this)(z.session, z.component, z.value, z.standard_error); }
  void one(FrameEstimate& f) { (*this)(f.session, f.value, f.standard_error); }
  void one(TargetEstimate& t) { (*this)(t.sensor, t.value, t.standard_error); }
  void one(Linearisation& l) { (*this)(l.residual, l.jacobian); }
  void one(PredictionFailure& f) { (*this)(f.reading, f.reason); }
  void one(CondensedFit& r) { (*this)(r.values, r.cost); }
  void one(Signature& s) { (*this)(s.columns, s.growth); }
  void one(ParameterEstimate& e) { (*this)(e.value, e.standard_error, e.hit); }
  void one(Parameter::Prior& p) { (*this)(p.mean, p.deviation, p.group, p.times); }
  // All but the springs, which the robot says.
  void one(Parameter& p) {
    (*this)(p.name, p.start, p.lower, p.upper, p.longest_step, p.bounds_stated, p.unit, p.typical,
            p.prior, p.effect, p.value);
  }
  // Structured bindings, so that a member which is added here is not forgotten.
  void one(Predictions& predictions) {
    auto& [displacement, derivatives, by_wrench, work, loaded, unloaded, few_states, failure] =
        predictions;
    (*this)(displacement, derivatives, by_wrench, work, loaded, unloaded, few_states, failure);
  }
  void one(BaseFit& fit) {
    auto& [parameters, zeros, frames, targets, covariance, error_source, weak, loss, weights,
           predicted, work, model, at, squared_error, values, iterations, is_settled, estimated] =
        fit;
    (*this)(parameters, zeros, frames, targets, covariance, error_source, weak, loss, weights,
            predicted, work, model, at, squared_error, values, iterations, is_settled, estimated);
  }

  Stream& stream_;
};

// Copies, because writing and reading are one function.
template <class... T>
std::string bytes_of(T... values) {
  Writer writer;
  Members<Writer>{writer}(values...);
  return writer.bytes();
}

template <class... T>
bool read(const std::string& bytes, T&... values) {
  try {
    Reader reader(bytes);
    Members<Reader>{reader}(values...);
    return reader.at_end();
  } catch (const std::logic_error&) {  // too short, or no rotation matrix
    return false;
  }
}

// A place names its sites, and a kind its law: the robot file says both.
std::string bytes_of_effect(const vjm::Effect& effect) {
  return bytes_of(effect.kind->name, effect.at, effect.values);
}

std::string bytes_of_candidate(const Candidate& candidate) {
  return bytes_of_effect(candidate.effect) + bytes_of(candidate.deviations);
}

template <class List, class BytesOf>
std::string joined(const List& list, const BytesOf& bytes_of_one) {
  std::string result = bytes_of(list.size());
  for (const auto& entry : list) result += bytes_of_one(entry);
  return result;
}

enum class Outcome { fit, not_identifiable, signatures, condensed };

}  // namespace

std::string fit_scope(const Campaign& campaign, const Noise& noise) {
  std::string bytes = bytes_of(noise.source, noise.comparable, noise.sigma,
                               noise.degrees_of_freedom, noise.correlation.size());
  for (const auto& correlation : noise.correlation)
    bytes += correlation ? bytes_of(true, *correlation) : bytes_of(false);
  for (const Datum& datum : noise.datums) bytes += bytes_of(datum.readings, datum.sigma);
  for (const Reading& reading : campaign.readings) bytes += bytes_of(reading.masked);
  return io::sha256(bytes);
}

std::string fit_key(const std::string& scope, const std::vector<vjm::Effect>& effects,
                    const std::vector<Parameter>& unknowns, const Predictions* near,
                    double least_gain) {
  return io::sha256(bytes_of(Outcome::fit, scope, least_gain) + joined(effects, bytes_of_effect) +
                    bytes_of(unknowns, near != nullptr) + (near == nullptr ? "" : bytes_of(*near)));
}

std::string condensed_key(const std::string& scope, const std::vector<vjm::Effect>& effects,
                          const std::vector<Parameter>& unknowns, const std::string& beside) {
  return io::sha256(bytes_of(Outcome::condensed, scope, beside) + joined(effects, bytes_of_effect) +
                    bytes_of(unknowns));
}

std::string signatures_key(const std::string& scope, const Candidate& candidate,
                           const std::string& beside) {
  return io::sha256(bytes_of(Outcome::signatures, scope, beside) + bytes_of_candidate(candidate));
}

std::string fitted_key(const std::vector<Candidate>& present, const BaseFit& fit) {
  return io::sha256(joined(present, bytes_of_candidate) + bytes_of(fit));
}

std::string record_of(const BaseFit& fit) { return bytes_of(Outcome::fit, fit); }

std::string record_of(const common::NotIdentifiable& failure) {
  return bytes_of(Outcome::not_identifiable, std::string(failure.what()));
}

std::string record_of(const CandidateSignatures& signatures) {
  std::vector<Eigen::VectorXd> starts;
  for (const Candidate& start : signatures.starts) starts.push_back(start.effect.values);
  return bytes_of(Outcome::signatures, signatures.all, starts, signatures.failure);
}

std::string record_of(const std::optional<CondensedFit>& rough) {
  return bytes_of(Outcome::condensed, rough);
}

std::optional<std::optional<CondensedFit>> recorded_condensed_fit(
    const std::string& record, const std::vector<Parameter>& unknowns) {
  Outcome outcome = Outcome::fit;
  std::optional<CondensedFit> rough;
  if (!read(record, outcome, rough) || outcome != Outcome::condensed) return std::nullopt;
  if (rough && rough->values.size() != std::ssize(unknowns)) return std::nullopt;
  return rough;
}

std::optional<BaseFit> recorded_fit(const std::string& record,
                                    const std::vector<Parameter>& unknowns) {
  Outcome outcome = Outcome::fit;
  std::string failure;
  if (read(record, outcome, failure) && outcome == Outcome::not_identifiable)
    throw common::NotIdentifiable(failure);
  BaseFit fit;
  if (!read(record, outcome, fit) || outcome != Outcome::fit) return std::nullopt;
  if (fit.parameters.size() != unknowns.size()) return std::nullopt;
  for (std::size_t k = 0; k < unknowns.size(); ++k) fit.parameters[k].parameter = unknowns[k];
  return fit;
}

std::optional<CandidateSignatures> recorded_signatures(const std::string& record,
                                                       const Candidate& candidate) {
  Outcome outcome = Outcome::signatures;
  CandidateSignatures signatures;
  std::vector<Eigen::VectorXd> starts;
  if (!read(record, outcome, signatures.all, starts, signatures.failure) ||
      outcome != Outcome::signatures || starts.size() != signatures.all.size())
    return std::nullopt;
  for (Eigen::VectorXd& values : starts) {
    signatures.starts.push_back(candidate);
    signatures.starts.back().effect.values = std::move(values);
  }
  return signatures;
}

}  // namespace kinetostat::calibration
