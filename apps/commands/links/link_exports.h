// Files of an identified link for other programs.
#pragma once

#include <string>

#include "kinetostat/apps/cli/option_list.h"
#include "kinetostat/fea/link/identify.h"

namespace kinetostat::apps {

/// Paths; empty when not asked for.
struct LinkExports {
  std::string deck, msh, csv, matlab;

  void add_options(OptionList& app);
  bool any() const { return !(deck.empty() && msh.empty() && csv.empty() && matlab.empty()); }
  void write(const fea::LinkResult& result) const;
};

}  // namespace kinetostat::apps
