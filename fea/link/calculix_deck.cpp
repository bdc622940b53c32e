#include "kinetostat/fea/link/calculix_deck.h"

#include <algorithm>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/common/index.h"
#include "kinetostat/common/printable.h"
#include "kinetostat/fea/interface/average_motion.h"

namespace kinetostat::fea {
namespace {

using common::at;

// One line of an *EQUATION.
struct Term {
  int node, direction;  // both from 1
  double coefficient;
};

class Deck {
 public:
  Deck(const TetMesh& mesh, const std::vector<Material>& materials,
       const std::vector<CoupledInterface>& interfaces)
      : mesh_(mesh), materials_(materials), interfaces_(interfaces) {}

  std::string text(const std::string& title) {
    heading(title);
    nodes();
    elements();
    for (std::size_t m = 0; m < materials_.size(); ++m) material(m);
    for (std::size_t i = 0; i < interfaces_.size(); ++i) node_set(i);
    hold_first();
    for (std::size_t i = 1; i < interfaces_.size(); ++i) couple(i);
    for (std::size_t i = 1; i < interfaces_.size(); ++i)
      for (int wrench = 0; wrench < 6; ++wrench) step(i, wrench);
    return std::move(text_);
  }

 private:
  template <class... Arguments>
  void add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Arguments>(arguments)...);
  }

  // The two reference nodes of a loaded interface: for translation and for rotation.
  int translation_node(std::size_t i) const {
    return static_cast<int>(mesh_.nodes.size() + 2 * i - 1);
  }
  int rotation_node(std::size_t i) const { return translation_node(i) + 1; }

  void heading(const std::string& title) {
    // CalculiX takes a line that starts with '*' for a keyword, *INCLUDE among them, and cuts long
    // lines in two.
    add("*HEADING\nLink {}\n** SI units: m, N, Pa. Interfaces:\n", common::plain_name(title));
    for (std::size_t i = 0; i < interfaces_.size(); ++i)
      add("**   {} {}: {} coupling, {}\n", i == 0 ? "fixed" : "loaded",
          common::plain_name(interfaces_[i].name), name(interfaces_[i].coupling),
          i == 0 ? std::string("held")
                 : fmt::format("translation of its point at node {}, rotation at node {}",
                               translation_node(i), rotation_node(i)));
  }

  void node(int number, const Vector3& p) {
    // CalculiX reads fields of at most 20 characters.
    add("{}, {:.12e}, {:.12e}, {:.12e}\n", number, p.x(), p.y(), p.z());
  }

  void nodes() {
    add("*NODE, NSET=NALL\n");
    for (std::size_t n = 0; n < mesh_.nodes.size(); ++n)
      node(static_cast<int>(n) + 1, mesh_.nodes[n]);
    for (std::size_t i = 1; i < interfaces_.size(); ++i) {
      add("*NODE, NSET=REF{}\n", i);
      node(translation_node(i), interfaces_[i].point);
      add("*NODE, NSET=ROT{}\n", i);
      node(rotation_node(i), interfaces_[i].point);
    }
  }

  void elements() {
    for (std::size_t m = 0; m < materials_.size(); ++m) {
      add("*ELEMENT, TYPE={}, ELSET=PART{}\n", mesh_.order == 2 ? "C3D10" : "C3D4", m + 1);
      for (std::size_t e = 0; e < mesh_.element_count(); ++e) {
        if (mesh_.material_of(e) != m) continue;
        add("{}", e + 1);
        for (const int n : mesh_.element(e)) add(", {}", n + 1);
        add("\n");
      }
    }
  }

  void material(std::size_t m) {
    add("*MATERIAL, NAME=MATERIAL{}\n*ELASTIC\n{:.12e}, {:.12e}\n", m + 1, materials_[m].young(),
        materials_[m].poisson());
    add("*SOLID SECTION, ELSET=PART{}, MATERIAL=MATERIAL{}\n", m + 1, m + 1);
  }

  void node_set(std::size_t i) {
    add("*NSET, NSET=INTERFACE{}\n", i);
    for (const int n : interfaces_[i].geometry.nodes) add("{},\n", n + 1);
  }

  void equation(const std::vector<Term>& terms) {
    add("*EQUATION\n{}\n", terms.size());
    for (const Term& t : terms) add("{}, {}, {:.12e}\n", t.node, t.direction, t.coefficient);
  }

  // The first interface does not move: its nodes, or the six means of its motion. There, each
  // equation must have a first term that no other has, which elimination sees to.
  void hold_first() {
    if (interfaces_[0].coupling == Coupling::rigid) {
      add("*BOUNDARY\nINTERFACE0, 1, 3, 0.\n");
      return;
    }
    const AverageMotion motion(mesh_, interfaces_[0].geometry, interfaces_[0].point);
    Eigen::MatrixXd rows = motion.nodal_forces().transpose();
    for (Eigen::Index k = 0; k < 6; ++k) {
      Eigen::Index pivot = 0;
      rows.row(k).cwiseAbs().maxCoeff(&pivot);
      rows.row(k) /= rows(k, pivot);
      for (Eigen::Index other = 0; other < 6; ++other)
        if (other != k) rows.row(other) -= rows(other, pivot) * rows.row(k);
      pivots_.push_back(pivot);
    }
    for (Eigen::Index k = 0; k < 6; ++k) {
      const auto pivot = pivots_[at(k)];
      std::vector<Term> terms{term(motion, pivot, 1)};
      for (Eigen::Index column = 0; column < rows.cols(); ++column)
        if (column != pivot && !is_pivot(column) && rows(k, column) != 0)
          terms.push_back(term(motion, column, rows(k, column)));
      equation(terms);
    }
  }

  bool is_pivot(Eigen::Index column) const {
    return std::find(pivots_.begin(), pivots_.end(), column) != pivots_.end();
  }

  static Term term(const AverageMotion& motion, Eigen::Index column, double coefficient) {
    return {motion.nodes()[at(column / 3)] + 1, static_cast<int>(column % 3) + 1, coefficient};
  }

  void couple(std::size_t i) {
    if (interfaces_[i].coupling == Coupling::rigid) {
      add("*RIGID BODY, NSET=INTERFACE{}, REF NODE={}, ROT NODE={}\n", i, translation_node(i),
          rotation_node(i));
      return;
    }
    const AverageMotion motion(mesh_, interfaces_[i].geometry, interfaces_[i].point);
    const Eigen::MatrixXd& forces = motion.nodal_forces();
    for (int k = 0; k < 6; ++k) {
      std::vector<Term> terms{{k < 3 ? translation_node(i) : rotation_node(i), k % 3 + 1, -1}};
      for (Eigen::Index row = 0; row < forces.rows(); ++row)
        if (forces(row, k) != 0) terms.push_back(term(motion, row, forces(row, k)));
      equation(terms);
    }
  }

  void step(std::size_t i, int wrench) {
    add("*STEP\n*STATIC\n*CLOAD, OP=NEW\n{}, {}, 1.\n",
        wrench < 3 ? translation_node(i) : rotation_node(i), wrench % 3 + 1);
    for (std::size_t k = 1; k < interfaces_.size(); ++k)
      add("*NODE PRINT, NSET=REF{}\nU\n*NODE PRINT, NSET=ROT{}\nU\n", k, k);
    add("*END STEP\n");
  }

  const TetMesh& mesh_;
  const std::vector<Material>& materials_;
  const std::vector<CoupledInterface>& interfaces_;
  std::vector<Eigen::Index> pivots_;
  std::string text_;
};

}  // namespace

std::string calculix_deck(const std::string& title, const TetMesh& mesh,
                          const std::vector<Material>& materials,
                          const std::vector<CoupledInterface>& interfaces) {
  return Deck(mesh, materials, interfaces).text(title);
}

// Rows "node ux uy uz", the two nodes of each loaded interface in turn, step by step.
Eigen::MatrixXd read_calculix_flexibility(const std::string& dat, int loaded_interfaces) {
  const Eigen::Index size = Eigen::Index{6} * loaded_interfaces;
  Eigen::MatrixXd flexibility(size, size);
  std::istringstream lines(dat);
  Eigen::Index count = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    long node = 0;
    Vector3 u;
    std::string rest;
    if (!(words >> node >> u.x() >> u.y() >> u.z()) || words >> rest) continue;
    if (3 * count < size * size) flexibility.reshaped().segment<3>(3 * count) = u;
    ++count;
  }
  if (3 * count != size * size)
    throw std::runtime_error(
        fmt::format("the .dat file has {} rows of displacements, not {}", count, size * size / 3));
  return flexibility;
}

}  // namespace kinetostat::fea
