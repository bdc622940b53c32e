// Text that others wrote, made fit for a terminal, a table or a line of another program's input.
#pragma once

#include <string>
#include <string_view>

namespace kinetostat::common {

/// Control characters are what terminals obey and what ends a line: U+0000 to U+001F, U+007F to
/// U+009F, U+2028 and U+2029.
bool has_control_characters(std::string_view text);

/// The text with '?' for every control character that is not in `kept`, and for every byte that is
/// not UTF-8. Everything else stays as it is.
std::string printable(std::string_view text, std::string_view kept = {});

/// printable() on one line, without `forbidden` and of at most `longest` bytes: for names in the
/// input of programs that give some characters a meaning or cut long lines in two.
std::string plain_name(std::string_view text, std::string_view forbidden = {},
                       std::size_t longest = 200);

}  // namespace kinetostat::common
