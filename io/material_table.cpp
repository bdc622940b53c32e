#include "kinetostat/io/material_table.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace kinetostat::io {
namespace {

// One standard deviation in parts of E, and where it comes from.
struct Spread {
  double share;
  const char* source;
};

const Spread of_steel{0.03, "JCSS Probabilistic Model Code, part 3.02 (2001): 3 % for steel"};
const Spread of_light_alloy{0.02, "assumed: handbooks differ by 3 % to either side"};

// Half the width of a range, beside its middle, as a rectangle.
Spread range(double low, double high, const char* source) {
  return {(high - low) / (high + low) / std::sqrt(3.0), source};
}

NamedMaterial entry(const char* name, const char* words, double young_gpa, double poisson,
                    double density, const char* source, const Spread& spread) {
  return {name,    words,   1e9 * young_gpa, 1e9 * young_gpa * spread.share,
          poisson, density, source,          spread.source};
}

std::vector<NamedMaterial> steels() {
  const char* structural = "EN 1993-1-1:2005, 3.2.6";
  const char* machine = "E, nu as EN 1993-1-1:2005, 3.2.6";
  const char* stainless = "EN 10088-1:2014, annex E; nu EN 1993-1-4, 2.1.3";
  return {
      entry("steel_s235", "structural steel S235 (1.0038)", 210, 0.3, 7850, structural, of_steel),
      entry("steel_s355", "structural steel S355 (1.0577)", 210, 0.3, 7850, structural, of_steel),
      entry("steel_c45", "heat-treatable steel C45 (1.0503)", 210, 0.3, 7850, machine, of_steel),
      entry("steel_42crmo4", "heat-treatable steel 42CrMo4 (1.7225)", 210, 0.3, 7850, machine,
            of_steel),
      entry("steel_100cr6", "bearing steel 100Cr6 (1.3505)", 210, 0.3, 7830, machine, of_steel),
      entry("stainless_1_4301", "stainless steel X5CrNi18-10 (AISI 304)", 200, 0.3, 7900, stainless,
            of_steel),
      entry("stainless_1_4404", "stainless steel X2CrNiMo17-12-2 (AISI 316L)", 200, 0.3, 8000,
            stainless, of_steel),
      entry("stainless_1_4542", "stainless steel X5CrNiCuNb16-4 (17-4 PH)", 200, 0.3, 7800,
            stainless, of_steel),
  };
}

std::vector<NamedMaterial> light_alloys() {
  const char* eurocode = "EN 1999-1-1:2007, 3.2.5";
  const char* handbook = "MIL-HDBK-5J (2003), chapter 3";
  return {
      entry("aluminium_5083", "aluminium EN AW-5083", 70, 0.3, 2700, eurocode, of_light_alloy),
      entry("aluminium_6061", "aluminium EN AW-6061", 68.3, 0.33, 2700, handbook, of_light_alloy),
      entry("aluminium_6082", "aluminium EN AW-6082", 70, 0.3, 2700, eurocode, of_light_alloy),
      entry("aluminium_7075", "aluminium EN AW-7075", 71, 0.33, 2800, handbook, of_light_alloy),
      entry("magnesium_az31", "magnesium AZ31B", 44.8, 0.35, 1770, "MIL-HDBK-5J (2003), chapter 4",
            of_light_alloy),
      entry("titanium_ti6al4v", "titanium Ti-6Al-4V (grade 5)", 110, 0.31, 4430,
            "MIL-HDBK-5J (2003), chapter 5", {0.03, "assumed: textures differ by 5 %"}),
  };
}

std::vector<NamedMaterial> castings_and_others() {
  const char* grey = "EN 1561:2011, annex A";
  const char* nodular = "EN 1563:2018, annex A";
  const Spread of_nodular{0.03, "assumed: 5 % to either side, by the shape of the graphite"};
  return {
      entry("cast_iron_gjl_250", "grey cast iron EN-GJL-250", 110.5, 0.26, 7200, grey,
            range(103, 118, "range of EN 1561:2011, annex A: 103 to 118 GPa")),
      entry("cast_iron_gjl_300", "grey cast iron EN-GJL-300", 122.5, 0.26, 7250, grey,
            range(108, 137, "range of EN 1561:2011, annex A: 108 to 137 GPa")),
      entry("cast_iron_gjs_400", "nodular cast iron EN-GJS-400-15", 169, 0.275, 7100, nodular,
            of_nodular),
      entry("brass_cuzn39pb3", "free-cutting brass CuZn39Pb3 (CW614N)", 97, 0.34, 8470,
            "data sheets of the German copper institute",
            {0.03, "assumed: data sheets differ by 5 %"}),
      entry("granite", "granite of machine beds", 50, 0.25, 2900,
            "Slocum, Precision Machine Design (1992), chapter 7",
            range(35, 65, "assumed: kinds of rock lie between 35 and 65 GPa")),
      entry("polymer_concrete", "polymer concrete (mineral casting)", 35, 0.25, 2400,
            "Slocum, Precision Machine Design (1992), chapter 7",
            range(30, 40, "assumed: mixtures lie between 30 and 40 GPa")),
      entry("concrete_c30_37", "concrete C30/37", 33, 0.2, 2400, "EN 1992-1-1:2004, table 3.1",
            {0.15, "JCSS Probabilistic Model Code, part 3.01 (2000): 15 %"}),
  };
}

}  // namespace

const std::vector<NamedMaterial>& named_materials() {
  static const std::vector<NamedMaterial> all = [] {
    std::vector<NamedMaterial> list = steels();
    for (const auto& more : {light_alloys(), castings_and_others()})
      list.insert(list.end(), more.begin(), more.end());
    return list;
  }();
  return all;
}

std::vector<std::string> material_names() {
  std::vector<std::string> names;
  for (const NamedMaterial& material : named_materials()) names.push_back(material.name);
  return names;
}

const NamedMaterial& named_material(const std::string& name) {
  const auto& all = named_materials();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const auto& m) { return m.name == name; });
  if (found == all.end()) throw std::out_of_range("no material " + name);
  return *found;
}

}  // namespace kinetostat::io
