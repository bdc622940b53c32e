#include "kinetostat/fea/link/matrix_export.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <iterator>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/printable.h"
#include "kinetostat/io/csv.h"

namespace kinetostat::fea {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr const char* motions[] = {"tx", "ty", "tz", "rx", "ry", "rz"};
constexpr const char* loads[] = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};

// "tip.Fx" and so on, of the interfaces from number `first` on.
std::vector<std::string> names(const std::vector<CoupledInterface>& interfaces, std::size_t first,
                               const char* const (&coordinates)[6]) {
  std::vector<std::string> list;
  for (std::size_t i = first; i < interfaces.size(); ++i)
    for (const char* coordinate : coordinates)
      list.push_back(fmt::format("{}.{}", interfaces[i].name, coordinate));
  return list;
}

Eigen::MatrixXd symmetric(const LinkResult& result) {
  const Eigen::MatrixXd& f = result.response.flexibility;
  return 0.5 * (f + f.transpose());
}

std::vector<double> row(const Eigen::MatrixXd& matrix, Eigen::Index i) {
  const Eigen::VectorXd values = matrix.row(i);
  return {values.begin(), values.end()};
}

// A text in MATLAB's single quotes, which end with the line.
std::string quoted(std::string text) {
  text = common::printable(text);
  for (std::size_t at = 0; (at = text.find('\'', at)) != std::string::npos; at += 2)
    text.insert(at, 1, '\'');
  return "'" + text + "'";
}

std::string quoted_list(std::vector<std::string> list) {
  std::transform(list.begin(), list.end(), list.begin(), quoted);
  return fmt::format("{{{}}}", fmt::join(list, ", "));
}

std::string points(const std::vector<CoupledInterface>& interfaces, std::size_t first) {
  std::string text = "[";
  for (std::size_t i = first; i < interfaces.size(); ++i) {
    const Vector3& p = interfaces[i].point;
    text += fmt::format("{}{} {} {}", i == first ? "" : "; ", p.x(), p.y(), p.z());
  }
  return text + "];\n";
}

std::string matrix(const char* name, const Eigen::MatrixXd& values) {
  std::string text = fmt::format("{} = [\n", name);
  for (Eigen::Index i = 0; i < values.rows(); ++i)
    text += fmt::format("  {}\n", fmt::join(row(values, i), " "));
  return text + "];\n";
}

// Of the reduced models.
namespace of_reduced {

constexpr const char* lost[] = {
    "large motions, unless the program turns the matrices along: they are linear, in the axes of "
    "the mesh",
    "damping, gravity, and the stiffness that loads and turning fast add or take"};

MatrixXd origins_of(const ModalResult& result) {
  MatrixXd origins(std::ssize(result.interfaces), 3);
  for (std::size_t i = 0; i < result.interfaces.size(); ++i)
    origins.row(static_cast<Index>(i)) = result.interfaces[i].point.transpose();
  return origins;
}

std::string comment(const ModalResult& result, const char* start) {
  std::string text = fmt::format(
      "{}Reduced model of the free link {}, by Craig and Bampton, from "
      "kinetostat. SI units, mesh axes.\n",
      start, common::printable(result.name));
  for (const char* what : lost) text += fmt::format("{}Not in this file: {}.\n", start, what);
  return text;
}

// --- MAT-file, level 4

void append_number(std::string& bytes, std::int32_t number) {
  for (int k = 0; k < 4; ++k)
    bytes += static_cast<char>(static_cast<std::uint32_t>(number) >> (8 * k) & 0xff);
}

// Little-endian doubles, column by column.
void append_matrix(std::string& bytes, const std::string& name, const MatrixXd& values) {
  append_number(bytes, 0);
  append_number(bytes, static_cast<std::int32_t>(values.rows()));
  append_number(bytes, static_cast<std::int32_t>(values.cols()));
  append_number(bytes, 0);
  append_number(bytes, static_cast<std::int32_t>(name.size() + 1));
  bytes.append(name.c_str(), name.size() + 1);
  for (Index j = 0; j < values.cols(); ++j)
    for (Index i = 0; i < values.rows(); ++i) {
      std::uint64_t bits = 0;
      const double value = values(i, j);
      std::memcpy(&bits, &value, sizeof bits);
      for (int k = 0; k < 8; ++k) bytes += static_cast<char>(bits >> (8 * k) & 0xff);
    }
}

// --- EXUDYN

std::string python_text(const std::string& text) {
  std::string out = "\"";
  for (const char c : common::printable(text)) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

std::string python_array(const std::string& name, const MatrixXd& values) {
  std::string text = fmt::format("{} = np.array([\n", name);
  for (Index i = 0; i < values.rows(); ++i) {
    text += "    [";
    for (Index j = 0; j < values.cols(); ++j)
      text += fmt::format("{}{}", j == 0 ? "" : ", ", values(i, j) + 0.0);
    text += "],\n";
  }
  return text + "])\n";
}

constexpr char exudyn_function[] = R"(

def add_to(mbs):
    """Adds the link to a main system of EXUDYN. Returns the numbers of its node, whose coordinates
    are the freedoms, and of its object; tie coordinates with CoordinateConstraint or
    CoordinateSpringDamper by MarkerNodeCoordinate."""
    from exudyn.itemInterface import NodeGenericODE2, ObjectGenericODE2

    size = len(freedoms)
    node = mbs.AddNode(NodeGenericODE2(
        referenceCoordinates=[0.0] * size, initialCoordinates=[0.0] * size,
        initialCoordinates_t=[0.0] * size, numberOfODE2Coordinates=size))
    body = mbs.AddObject(ObjectGenericODE2(nodeNumbers=[node], massMatrix=M, stiffnessMatrix=K))
    return node, body
)";

// --- CalculiX and Abaqus

// Letters, digits and underscores, as the names of sets must be.
std::string set_name(const std::string& name) {
  std::string out = "N_";
  for (const char c : name) out += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return out;
}

// Numbers have at most 20 characters, as CalculiX reads them.
class Deck {
 public:
  Deck(const ModalResult& result, const ReducedModel& model)
      : result_(result), size_(model.mass.rows()) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(model.stiffness, model.mass);
    // Of y = B q with B = X' M: q' K q is the sum of lambda y^2, q' M q that of y^2.
    lambda_ = modes.eigenvalues();
    to_modes_ = modes.eigenvectors().transpose() * model.mass;
    first_modal_ = 1 + (size_ + 2) / 3;
  }

  std::string run() && {
    text_ = comment(result_, "** ");
    add("** Clamp or load displacements 1, 2, 3 of these nodes. Rotations are displacements of "
        "nodes of their own.\n*NODE, NSET=N_all\n");
    for (Index block = 0; 3 * block < size_; ++block) add_node(1 + block, place_of(block));
    for (Index block = 0; 3 * block < size_; ++block)
      add_node(first_modal_ + block, Vector3::Zero());
    add_sets();
    add_masses();
    for (Index k = 0; k < size_; ++k) add_spring(k);
    for (Index k = 0; k < size_; ++k) add_equation(k);
    if (size_ % 3 != 0) add_boundary();
    return std::move(text_);
  }

 private:
  template <class... Arguments>
  void add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Arguments>(arguments)...);
  }

  // Three freedoms are the displacements of a node.
  Vector3 place_of(Index block) const {
    const auto i = static_cast<std::size_t>(block / 2);
    return i < result_.interfaces.size() ? result_.interfaces[i].point : Vector3::Zero();
  }
  void add_node(Index number, const Vector3& at) {
    add("{}, {:.9e}, {:.9e}, {:.9e}\n", number, at.x(), at.y(), at.z());
  }

  void add_sets() {
    for (std::size_t i = 0; i < result_.interfaces.size(); ++i) {
      const std::string name = set_name(result_.interfaces[i].name);
      add("*NSET, NSET={}_translation\n{}\n*NSET, NSET={}_rotation\n{}\n", name, 2 * i + 1, name,
          2 * i + 2);
    }
  }

  void add_masses() {
    add("*ELEMENT, TYPE=MASS, ELSET=E_masses\n");
    for (Index block = 0; 3 * block < size_; ++block)
      add("{}, {}\n", 1 + block, first_modal_ + block);
    add("*MASS, ELSET=E_masses\n1.\n");
  }

  // The first six modes are the rigid motions, which have none.
  void add_spring(Index k) {
    if (k < 6) return;
    const Index element = 1 + (size_ + 2) / 3 + k;
    add("*ELEMENT, TYPE=SPRING1, ELSET=E_{}\n{}, {}\n*SPRING, ELSET=E_{}\n{}\n{:.12e}\n", element,
        element, first_modal_ + k / 3, element, 1 + k % 3, lambda_[k]);
  }

  // The displacement of the mode is dependent, so that all others may be clamped.
  void add_equation(Index k) {
    add("*EQUATION\n{}\n{}, {}, -1.", size_ + 1, first_modal_ + k / 3, 1 + k % 3);
    for (Index j = 0; j < size_; ++j)
      add("{}{}, {}, {:.12e}", (j + 1) % 4 == 0 ? "\n" : ", ", 1 + j / 3, 1 + j % 3,
          to_modes_(k, j));
    add("\n");
  }

  // Displacements of the last nodes that stand for nothing.
  void add_boundary() {
    const Index used = size_ % 3, last = (size_ - 1) / 3;
    add("*BOUNDARY\n{}, {}, 3\n{}, {}, 3\n", 1 + last, used + 1, first_modal_ + last, used + 1);
  }

  const ModalResult& result_;
  Index size_, first_modal_ = 0;
  Eigen::VectorXd lambda_;
  MatrixXd to_modes_;
  std::string text_;
};

// --- MBDyn

class ModalData {
 public:
  ModalData(const ModalResult& result, const ReducedModel& model)
      : result_(result),
        nodes_(std::ssize(result.interfaces)),
        size_(model.mass.rows()),
        modes_(model.stiffness, model.mass) {}

  std::string run() && {
    text_ = comment(result_, "** ");
    for (Index i = 0; i < nodes_; ++i)
      text_ += fmt::format("** node {}: {}\n", i + 1,
                           common::printable(result_.interfaces[static_cast<std::size_t>(i)].name));
    begin("1, HEADER\n** REVISION, NODES, NORMAL, ATTACHMENT, CONSTRAINT, REJECTED MODES");
    text_ += fmt::format("REV0 {} {} 0 0 0\n", nodes_, size_ - 6);
    begin("2, FINITE ELEMENT NODE LIST");
    for (Index i = 0; i < nodes_; ++i) text_ += fmt::format("{}\n", i + 1);
    begin("3, INITIAL MODAL DISPLACEMENTS");
    add(Eigen::VectorXd::Zero(size_ - 6));
    begin("4, INITIAL MODAL VELOCITIES");
    add(Eigen::VectorXd::Zero(size_ - 6));
    for (Index k = 0; k < 3; ++k) {
      begin(fmt::format("{}, NODAL {} COORDINATES", 5 + k, "XYZ"[k]));
      add(origins_of(result_).col(k));
    }
    begin("8, MODE SHAPES");
    for (Index k = 6; k < size_; ++k) {
      text_ += fmt::format("** NORMAL MODE SHAPE # {}\n", k - 5);
      for (Index i = 0; i < nodes_; ++i) add(modes_.eigenvectors().col(k).segment<6>(6 * i));
    }
    begin("9, MODAL MASS MATRIX");
    for (Index k = 6; k < size_; ++k) add(Eigen::VectorXd::Unit(size_ - 6, k - 6));
    begin("10, MODAL STIFFNESS MATRIX");
    for (Index k = 6; k < size_; ++k)
      add(modes_.eigenvalues()[k] * Eigen::VectorXd::Unit(size_ - 6, k - 6));
    begin("12, RIGID BODY INERTIA");
    add(Eigen::VectorXd::Constant(1, result_.mass));
    add(result_.center_of_mass);
    for (Index i = 0; i < 3; ++i) add(result_.inertia.row(i).transpose());
    text_ += "**\n";
    return std::move(text_);
  }

 private:
  void begin(const std::string& group) { text_ += "**\n** RECORD GROUP " + group + "\n"; }
  void add(const Eigen::VectorXd& values) {
    text_ += fmt::format("{:.16e}\n", fmt::join(values.begin(), values.end(), " "));
  }

  const ModalResult& result_;
  Index nodes_, size_;
  Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes_;
  std::string text_;
};

}  // namespace of_reduced

}  // namespace

std::string flexibility_csv(const LinkResult& result) {
  const Eigen::MatrixXd f = symmetric(result);
  std::string text = "motion";
  for (const std::string& load : names(result.interfaces, 1, loads))
    text += "," + io::csv_cell(load);
  Eigen::Index i = 0;
  for (const std::string& motion : names(result.interfaces, 1, motions))
    text += fmt::format("\n{},{}", io::csv_cell(motion), fmt::join(row(f, i++), ","));
  return text + "\n";
}

std::string flexibility_matlab(const LinkResult& result) {
  const Eigen::MatrixXd f = symmetric(result);
  const std::string text = fmt::format(
      "% Flexibility of a link between its loaded interfaces, the fixed one at rest.\n"
      "% Columns: loads [N, N m]; rows: motions [m, rad]; mesh axes; points in m.\n"
      "name = {};\nmotions = {};\nloads = {};\n",
      quoted(result.name), quoted_list(names(result.interfaces, 1, motions)),
      quoted_list(names(result.interfaces, 1, loads)));
  return text + "points = " + points(result.interfaces, 1) + matrix("flexibility", f) +
         "stiffness = inv(flexibility);\n";
}

std::string reduced_matlab(const ModalResult& result, const ReducedModel& model) {
  std::vector<std::string> freedoms = names(result.interfaces, 0, motions);
  for (Eigen::Index k = model.interface_motions; k < model.mass.rows(); ++k)
    freedoms.push_back(fmt::format("mode {}", k - model.interface_motions + 1));
  return fmt::format(
             "% Stiffness and mass of a free link, by Craig and Bampton's method: motions of its\n"
             "% interfaces at their origins, then modes with these held. SI units, mesh axes.\n"
             "name = {};\nfreedoms = {};\norigins = ",
             quoted(result.name), quoted_list(freedoms)) +
         points(result.interfaces, 0) + matrix("K", model.stiffness) + matrix("M", model.mass);
}

std::string reduced_mat(const ModalResult& result, const ReducedModel& model) {
  using namespace of_reduced;
  std::string bytes;
  append_matrix(bytes, "K", model.stiffness);
  append_matrix(bytes, "M", model.mass);
  append_matrix(bytes, "origins", origins_of(result));
  return bytes;
}

std::string reduced_exudyn(const ModalResult& result, const ReducedModel& model) {
  using namespace of_reduced;
  std::string text = comment(result, "# ") +
                     "import numpy as np\n\nname = " + python_text(result.name) +
                     "\nfreedoms = [\n";
  for (const CoupledInterface& interface : result.interfaces)
    for (const char* motion : motions)
      text += fmt::format("    {},\n", python_text(interface.name + "." + motion));
  for (Index k = model.interface_motions; k < model.mass.rows(); ++k)
    text += fmt::format("    \"mode {}\",\n", k - model.interface_motions + 1);
  return text + "]\n" + python_array("origins", origins_of(result)) +
         python_array("K", model.stiffness) + python_array("M", model.mass) + exudyn_function;
}

std::string reduced_deck(const ModalResult& result, const ReducedModel& model) {
  using namespace of_reduced;
  return Deck(result, model).run();
}

std::string reduced_mbdyn(const ModalResult& result, const ReducedModel& model) {
  using namespace of_reduced;
  return ModalData(result, model).run();
}

}  // namespace kinetostat::fea
