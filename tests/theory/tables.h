// Tables of docs/theory as Markdown, computed from the shipped robots.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::theory {

/// Rows of cells with a heading, as a Markdown table.
std::string markdown(const std::vector<std::string>& heading,
                     const std::vector<std::vector<std::string>>& rows);

vjm::Robot shipped(const std::string& name);

/// The characteristic points of the Orthoglide, named as in NONPERF and MMT11.
struct NamedPoint {
  const char* name;
  spatial::Vector3 position;  // [m]
};
extern const std::vector<NamedPoint> orthoglide_points;

std::string decision_rules();           // of a diagnosis
std::string jamris_table_1_and_3();     // 3-PUU
std::string jamris_table_2();           // 3-PRPaR
std::string nonperf_table_1();          // assembly, case A
std::string nonperf_table_2();          // assembly, case B
std::string mmt11_table_2_unloaded();   // unloaded stiffness along (1, 1, 1)
std::string iros11_platforms();         // Stewart-Gough matrices (27), (28) against (25)-(26)
std::string mmt11_urrs();               // critical forces of models A, B, C
std::string straight_column();          // critical force over the number of segments
std::string mmt11_table_2_critical();   // first critical point along (1, 1, 1)
std::string iterations_at_a_pose();     // Newton against MMT11 eq. 10
std::string iterations_under_a_load();  // Newton against MMT11 eq. 11

}  // namespace kinetostat::theory
