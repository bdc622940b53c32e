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

// A text of Python or C++.
std::string double_quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : common::printable(text)) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

// Letters, digits and underscores alone, as names of sets and namespaces must be.
std::string identifier(std::string out, const std::string& name) {
  for (const char c : name) out += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return out;
}

// --- EXUDYN

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
      const std::string name = identifier("N_", result_.interfaces[i].name);
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

// --- Chrono

// Chrono counts coordinates inside by nodes of six, and searches modes in a subspace of twice as
// many: where there are hardly more coordinates than modes, it misses high ones. The others are
// oscillators on their own, above all modes.
ReducedModel in_whole_nodes(const ReducedModel& model) {
  const Index size = model.mass.rows(), modes = size - model.interface_motions, others = modes + 3,
              whole = 6 * ((size + others + 5) / 6);
  ReducedModel out{.stiffness = MatrixXd::Zero(whole, whole),
                   .mass = MatrixXd::Identity(whole, whole),
                   .interface_motions = model.interface_motions};
  out.stiffness.topLeftCorner(size, size) = model.stiffness;
  out.mass.topLeftCorner(size, size) = model.mass;
  const double highest = model.stiffness.diagonal().tail(modes).maxCoeff();
  for (Index k = size; k < whole; ++k)
    out.stiffness(k, k) = static_cast<double>((k - size + 2) * (k - size + 2)) * highest;
  return out;
}

std::string cpp_entries(const char* name, const MatrixXd& values) {
  std::string text = fmt::format("constexpr Entry {}[] = {{\n", name);
  for (Index i = 0; i < values.rows(); ++i)
    for (Index j = 0; j < values.cols(); ++j)
      if (values(i, j) != 0) text += fmt::format("    {{{}, {}, {}}},\n", i, j, values(i, j));
  return text + "};\n\n";
}

std::string cpp_interfaces(const ModalResult& result) {
  std::string text = "constexpr Interface interfaces[] = {\n";
  for (const CoupledInterface& interface : result.interfaces) {
    const Vector3& p = interface.point;
    text += fmt::format("    {{{}, {{{}, {}, {}}}}},\n", double_quoted(interface.name), p.x(),
                        p.y(), p.z());
  }
  return text + "};\n\n";
}

constexpr char chrono_start[] = R"(#pragma once

#include <memory>
#include <vector>

#include "chrono/fea/ChMesh.h"
#include "chrono/fea/ChNodeFEAxyzrot.h"
#include "chrono/physics/ChSystem.h"
#include "chrono_modal/ChModalAssembly.h"

)";

constexpr char chrono_types[] = R"(struct Interface {
  const char* name;
  double point[3];
};

struct Entry {
  int row, column;  // from 0 on
  double value;
};

)";

constexpr char chrono_function[] = R"(struct Link {
  std::shared_ptr<chrono::modal::ChModalAssembly> assembly;
  std::vector<std::shared_ptr<chrono::fea::ChNodeFEAxyzrot>> nodes;  // of the interfaces
};

// Translations in absolute axes and rotations in those of the nodes, as Chrono has them.
template <int count>
chrono::ChSparseMatrix matrix(const Entry (&entries)[count], const chrono::ChFrame<>& frame) {
  std::vector<Eigen::Triplet<double>> values, turns;
  for (const Entry& entry : entries) values.emplace_back(entry.row, entry.column, entry.value);
  for (int k = 0; k < size; ++k)
    if (k % 6 >= 3)
      turns.emplace_back(k, k, 1.0);
    else
      for (int j = 0; j < 3; ++j) turns.emplace_back(k, k - k % 3 + j, frame.GetRotMat()(k % 3, j));
  chrono::ChSparseMatrix given(size, size), turn(size, size);
  given.setFromTriplets(values.begin(), values.end());
  turn.setFromTriplets(turns.begin(), turns.end());
  const chrono::ChSparseMatrix back = turn.transpose();
  return turn * given * back;
}

// Adds the link to a system, the axes of the mesh at `frame`, with a node at the point of each
// interface: join these to others, load them. `solver` finds the modes again: give it their number,
// as ChModalSolverUndamped<ChUnsymGenEigenvalueSolverKrylovSchur>(modes).
template <class ModalSolver>
Link add_to(chrono::ChSystem& system, const ModalSolver& solver,
            const chrono::ChFrame<>& frame = chrono::ChFrame<>(),
            const chrono::modal::ChModalDamping& damping = chrono::modal::ChModalDampingNone()) {
  using namespace chrono;
  Link link;
  link.assembly = chrono_types::make_shared<modal::ChModalAssembly>();
  system.Add(link.assembly);
  link.assembly->SetReductionType(modal::ChModalAssembly::ReductionType::CRAIG_BAMPTON);
  link.assembly->SetInternalNodesUpdate(false);    // they are coordinates of modes
  link.assembly->SetModalAutomaticGravity(false);  // it would leave out moments about the nodes
  const auto outside = chrono_types::make_shared<fea::ChMesh>();
  const auto inside = chrono_types::make_shared<fea::ChMesh>();
  link.assembly->Add(outside);
  link.assembly->AddInternal(inside);
  const auto node_at = [&](const Interface& place) {
    const double* p = place.point;
    const ChVector3d point = frame.TransformPointLocalToParent(ChVector3d(p[0], p[1], p[2]));
    auto node = chrono_types::make_shared<fea::ChNodeFEAxyzrot>(ChFrame<>(point, frame.GetRot()));
    node->SetMass(0);
    node->GetInertia().setZero();
    return node;
  };
  for (const Interface& place : interfaces) {
    link.nodes.push_back(node_at(place));
    outside->AddNode(link.nodes.back());
  }
  for (int k = 6 * static_cast<int>(link.nodes.size()); k < size; k += 6)
    inside->AddNode(node_at(interfaces[0]));
  ChSparseMatrix mass = matrix(M, frame), stiffness = matrix(K, frame), constraints(0, size);
  link.assembly->DoModalReduction(mass, stiffness, constraints, solver, damping);
  return link;
}
)";

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
                     "import numpy as np\n\nname = " + double_quoted(result.name) +
                     "\nfreedoms = [\n";
  for (const CoupledInterface& interface : result.interfaces)
    for (const char* motion : motions)
      text += fmt::format("    {},\n", double_quoted(interface.name + "." + motion));
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

std::string reduced_chrono(const ModalResult& result, const ReducedModel& model) {
  using namespace of_reduced;
  const ReducedModel nodal = in_whole_nodes(model);
  const std::string name = identifier("link_", result.name);
  return comment(result, "// ") + chrono_start +
         fmt::format("namespace {} {{\n\nconstexpr int modes = {};\n", name,
                     model.mass.rows() - model.interface_motions) +
         fmt::format(
             "constexpr int size = {};  // of K and M: interfaces, modes, and oscillators on "
             "their own\n\n",
             nodal.mass.rows()) +
         chrono_types + cpp_interfaces(result) + cpp_entries("K", nodal.stiffness) +
         cpp_entries("M", nodal.mass) + chrono_function +
         fmt::format("\n}}  // namespace {}\n", name);
}

}  // namespace kinetostat::fea
