// How the help of a command shows its options.
#pragma once

#include <memory>

namespace CLI {
class FormatterBase;
}

namespace kinetostat::apps {

/// "--draws N   Simulated campaigns (default: 500)": what stands for the value beside the name, and
/// what else is to be known of an option, which others it needs or excludes, in its description.
std::shared_ptr<CLI::FormatterBase> help_formatter();

}  // namespace kinetostat::apps
